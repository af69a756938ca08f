// Turns maps on a grid into maps of every pixel and into three classes.
//
//   values   linear between the grid's pixels (vision/image/grid_interpolation.h)
//   class    0 (static) if p < static_below, 255 (dynamic) if p > dynamic_above, else 128
#pragma once

#include <opencv2/core.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/image/image_grid.h"

namespace egosieve::tools {

struct ClassThresholds {
  double static_below = 0.4;   // in [0, dynamic_above]
  double dynamic_above = 0.5;  // in [static_below, 1]

  // InvalidArgument, naming flag, value and rule.
  absl::Status Validate() const;
};

// values: grid.rows() x grid.columns().
absl::StatusOr<cv::Mat1f> InterpolateMap(const vision::ImageGrid& grid, const cv::Mat1f& values);

cv::Mat1b ClassifyMap(const cv::Mat1f& probability, const ClassThresholds& thresholds);

}  // namespace egosieve::tools
