// Labels as an 8-bit PNG with a palette, as the readers of DAVIS and PASCAL VOC expect: a pixel is
// its label, 0 to 255. The colours are those of VOC; no reader needs them.
#ifndef EGOSIEVE_TOOLS_MASKS_PALETTE_PNG_H_
#define EGOSIEVE_TOOLS_MASKS_PALETTE_PNG_H_

#include <opencv2/core.hpp>
#include <string>

#include "absl/status/statusor.h"

namespace egosieve::tools {

absl::StatusOr<std::string> EncodePalettePng(const cv::Mat1b& labels);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_PALETTE_PNG_H_
