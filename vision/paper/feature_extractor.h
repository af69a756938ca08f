// SIFT key points and Shi-Tomasi corners of a grey image with SIFT descriptors, in a requested
// number and spread evenly (paper, section III).
//
//   1. key points: extrema of the difference of Gaussians, orientation from gradients (Lowe, 2004)
//   2. corners (corner_detector.h), upright, described at one scale
//   3. each kind thinned to its share by spread.h; if one kind has too few, the other fills up
//   4. descriptors of 4 x 4 x 8 gradient histograms, 8-bit, by OpenCV
//
// Cost: 1-2 are linear in the pixels, 4 in the features.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/paper/feature_set.h"

namespace egosieve::vision {

// grey: CV_8UC1, not empty. An image without texture gives an empty set.
// As many features as 7,000 at 1242 x 375, by area, half of them key points.
absl::StatusOr<FeatureSet> ExtractFeatures(const cv::Mat& grey);

}  // namespace egosieve::vision
