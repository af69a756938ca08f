#include "tools/run_folder/doubtful_frames.h"

#include <algorithm>
#include <functional>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Masks are better than the map that expects so little (docs/decisions.md).
constexpr double kLeastOverlap = 0.4;

// Turns "only 17 of 300 features" into "only # of # features", to group reasons of one kind.
std::string WithoutNumbers(absl::string_view reason) {
  std::string text;
  for (size_t i = 0; i < reason.size(); ++i) {
    if (!absl::ascii_isdigit(reason[i])) {
      text.push_back(reason[i]);
    } else if (i == 0 || !absl::ascii_isdigit(reason[i - 1])) {
      text.push_back('#');
    }
  }
  return text;
}

}  // namespace

std::string DoubtOf(const FrameLine& line) {
  if (line.outcome == FrameLine::Outcome::kFailed) return line.reason;
  if (line.doubt.empty() && line.expected_overlap < kLeastOverlap) {
    return absl::StrFormat(
        "the map's probabilities expect an IoU of %.2f between its mask and what moves",
        line.expected_overlap);
  }
  return line.doubt;
}

void ReasonKinds::Add(const std::string& reason, int64_t frame) {
  Kind& kind = kinds_[WithoutNumbers(reason)];
  if (kind.frames.empty()) kind.first = reason;
  kind.frames.push_back(frame);
}

std::vector<ReasonKinds::Kind> ReasonKinds::MostFrequentFirst() const {
  std::vector<Kind> kinds;
  for (const auto& [text, kind] : kinds_) kinds.push_back(kind);
  std::ranges::stable_sort(kinds, std::greater<>(),
                           [](const Kind& kind) { return kind.frames.size(); });
  return kinds;
}

void DoubtfulFrames::Add(const FrameLine& line) {
  ++frames_;
  const std::string doubt = DoubtOf(line);
  if (line.outcome == FrameLine::Outcome::kLearnt) {
    // The first pair of pictures: so many frames before this one have none.
    if (learnt_++ == 0) not_learnt_ -= std::min(not_learnt_, line.frame_gap);
  } else if (line.outcome == FrameLine::Outcome::kAnswered && !doubt.empty()) {
    ++not_learnt_;
    not_learnt_reasons_.Add(line.reason, line.index);
  }
  if (doubt.empty()) return;
  ++count_;
  doubts_.Add(doubt, line.index);
}

std::string DoubtfulFrames::Sentence() const {
  if (count_ == 0) return "";
  return absl::StrCat(count_, " of ", frames_, " frames ", count_ == 1 ? "is" : "are",
                      " unreliable, most often: ", doubts_.MostFrequentFirst().front().first);
}

std::string DoubtfulFrames::TooFewLearnt() const {
  if (learnt_ >= not_learnt_) return "";
  return absl::StrCat("only ", learnt_, " of ", learnt_ + not_learnt_,
                      " frames were learnt from, the others most often not because: ",
                      not_learnt_reasons_.MostFrequentFirst().front().first);
}

}  // namespace egosieve::tools
