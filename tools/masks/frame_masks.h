// The masked pixels in the frames of a run.
//
//   moving     mask of refine; with a threshold: p >= threshold in its refined map   (FM1)
//   own        the own vehicle and the run's ignored area, if wanted                      (FM2)
//   dilated    pixels nearer than `dilate_pixels` to (FM1) and, if wanted, to the shadows of movers
//              (cast_shadows.h); each gets the number of the nearest mover                (FM3)
//   masked     the union of (FM2) and (FM3)
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct FrameMaskOptions {
  std::optional<double> threshold;  // none: refine's masks
  bool numbers = false;             // from refine's ids
  bool own_vehicle = false;         // mask it and the run's ignored area
  IgnoredAreas ignored;
  int dilate_pixels = 0;
  int shadow_margin_pixels = 0;  // 0: no shadows; not with numbers

  absl::Status Validate() const;
};

struct FrameMask {
  cv::Mat1b masked;   // 0 or 255
  cv::Mat1w numbers;  // 0 where not masked; empty unless wanted
};

// The file of refine from which a frame's mask is made.
std::string MaskSource(const RunFolder& folder, int64_t index, const FrameMaskOptions& options);

// DataLoss, naming the file, if it is missing, damaged or of another size. picture: the segmented
// picture, of any size; only used for shadows.
absl::StatusOr<FrameMask> ReadFrameMask(const RunFolder& folder, const FrameLine& line,
                                        const FrameMaskOptions& options,
                                        const cv::Mat3b& picture = {});

// (FM3), in place. numbers: may be empty.
void Dilate(int pixels, cv::Mat1b& masked, cv::Mat1w& numbers);

}  // namespace egosieve::tools
