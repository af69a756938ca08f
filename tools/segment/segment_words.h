// Words of segment's flags, and the words for their values in run.json.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SEGMENT_WORDS_H_
#define EGOSIEVE_TOOLS_SEGMENT_SEGMENT_WORDS_H_

#include <cstdint>
#include <string>

#include "tools/cli/checks.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

const Words<vision::Equalization>& EqualizationWords();
const Words<vision::ModelKind>& ModelWords();
const Words<vision::FlowQuality>& FlowQualityWords();
const Words<bool>& SwitchWords();
const Words<vision::OnlineSegmenterOptions (*)()>& Profiles();

// The labeller chooses the gap itself.
inline constexpr char kAutomatic[] = "auto";
inline constexpr int kAutomaticGap = 0;
// The labeller learns the focal length while frames arrive.
inline constexpr char kLearntOnTheWay[] = "learnt on the way";
// The label for the target zero: the model's own mean.
inline constexpr char kMeanLabel[] = "mean";
inline constexpr int64_t kUnlimitedAge = 1000000;  // frames

template <typename Value>
std::string NameOf(const Words<Value>& words, Value value) {
  for (const auto& [name, candidate] : words) {
    if (candidate == value) return name;
  }
  return "";
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SEGMENT_WORDS_H_
