// SIFT key points and Shi-Tomasi corners of a grey image with SIFT descriptors (Lowe, 2004), in a
// number that follows the area and spread evenly (paper, section III).
//
//   1. key points: extrema of the difference of Gaussians, orientation from gradients
//   2. corners (corner_detector.h), upright, described at one scale
//   3. each kind thinned to its share, evenly; if one kind has too few, the other fills up
//   4. descriptors of 4 x 4 x 8 gradient histograms, by OpenCV
//
// Cost: 1-2 are linear in the pixels, 4 in the features.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

// The features [0, key_point_count) are key points, the rest are corners.
struct FeatureSet {
  std::vector<cv::Point2f> positions;  // pixels, subpixel accuracy, inside the image
  cv::Mat descriptors;                 // size() x 128, CV_32F, whole numbers from 0 to 255
  int64_t key_point_count = 0;

  int64_t size() const { return static_cast<int64_t>(positions.size()); }
};

// grey: CV_8UC1, not empty. An image without texture gives an empty set.
// As many features as 7,000 at 1242 x 375, by area, half of them key points.
absl::StatusOr<FeatureSet> ExtractFeatures(const cv::Mat& grey);

}  // namespace egosieve::vision
