#include "tools/run_folder/doubtful_frames.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Masks are better than the map that expects so little (docs/decisions.md).
constexpr double kLeastOverlap = 0.4;

}  // namespace

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

std::string DoubtOf(const FrameLine& line) {
  if (line.outcome == FrameLine::Outcome::kFailed) return line.reason;
  if (line.doubt.empty() && line.expected_overlap < kLeastOverlap) {
    return absl::StrFormat(
        "the map's probabilities expect an IoU of %.2f between its mask and what moves",
        line.expected_overlap);
  }
  return line.doubt;
}

void ReasonKinds::Add(const std::string& reason) {
  Kind& kind = kinds_[WithoutNumbers(reason)];
  if (kind.count++ == 0) kind.first = reason;
}

std::string ReasonKinds::MostFrequent() const {
  const auto most = std::max_element(
      kinds_.begin(), kinds_.end(),
      [](const auto& a, const auto& b) { return a.second.count < b.second.count; });
  return most == kinds_.end() ? "" : most->second.first;
}

void DoubtfulFrames::Add(const FrameLine& line) {
  ++frames_;
  const std::string doubt = DoubtOf(line);
  if (line.outcome == FrameLine::Outcome::kLearnt) {
    // The first pair of pictures: so many frames before this one have none.
    if (learnt_++ == 0) not_learnt_ -= std::min(not_learnt_, line.frame_gap);
  } else if (line.outcome == FrameLine::Outcome::kAnswered && !doubt.empty()) {
    ++not_learnt_;
    not_learnt_reasons_.Add(line.reason);
  }
  if (doubt.empty()) return;
  ++count_;
  doubts_.Add(doubt);
}

std::string DoubtfulFrames::Sentence() const {
  if (count_ == 0) return "";
  return absl::StrCat(count_, " of ", frames_,
                      " frames are unreliable, most often: ", doubts_.MostFrequent());
}

std::string DoubtfulFrames::TooFewLearnt() const {
  if (learnt_ >= not_learnt_) return "";
  return absl::StrCat("only ", learnt_, " of ", learnt_ + not_learnt_,
                      " frames were learnt from, the others most often not because: ",
                      not_learnt_reasons_.MostFrequent());
}

}  // namespace egosieve::tools
