// Which shares of the moving pixels and of the other pixels are masked, according to true masks.
#ifndef EGOSIEVE_TOOLS_MASKS_COVERAGE_H_
#define EGOSIEVE_TOOLS_MASKS_COVERAGE_H_

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/statusor.h"

namespace egosieve::tools {

class Coverage {
 public:
  // truth: a folder of masks (tools/masks/truth_masks.h) for the frames of `input`, whose first
  // frame has the size `first_size`; empty: none.
  static absl::StatusOr<Coverage> Open(const std::string& truth, const std::string& input,
                                       cv::Size first_size);

  // Counts the frame's pixels if it has a true mask; void pixels do not count.
  absl::Status Add(int64_t index, const cv::Mat1b& masked);

  int64_t frames() const { return frames_; }  // frames with a true mask
  // Shares of the pixels; 0 if there are none.
  double MovingMasked() const;
  double RestMasked() const;
  // "masked: 0.953 of what moves, 0.021 of the rest, in 70 frames"
  std::string Describe() const;

 private:
  std::map<int64_t, std::string> truth_;  // paths by frame
  int64_t frames_ = 0, moving_ = 0, moving_masked_ = 0, rest_ = 0, rest_masked_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_COVERAGE_H_
