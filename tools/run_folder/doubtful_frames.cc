#include "tools/run_folder/doubtful_frames.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {

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
  return line.outcome == FrameLine::Outcome::kFailed ? line.reason : line.doubt;
}

void DoubtfulFrames::Add(const FrameLine& line) {
  ++frames_;
  const std::string doubt = DoubtOf(line);
  if (doubt.empty()) return;
  ++count_;
  Kind& kind = kinds_[WithoutNumbers(doubt)];
  if (kind.count++ == 0) kind.first = doubt;
}

std::string DoubtfulFrames::Sentence() const {
  if (count_ == 0) return "";
  const auto most = std::max_element(
      kinds_.begin(), kinds_.end(),
      [](const auto& a, const auto& b) { return a.second.count < b.second.count; });
  return absl::StrCat(count_, " of ", frames_,
                      " frames are unreliable, most often: ", most->second.first);
}

}  // namespace egosieve::tools
