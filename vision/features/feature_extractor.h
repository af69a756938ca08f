// SIFT key points and Shi-Tomasi corners of a grey image with SIFT descriptors, in a requested
// number and spread evenly (paper, section III).
//
//   1. key points: extrema of the difference of Gaussians, orientation from gradients (Lowe, 2004)
//   2. corners (corner_detector.h), upright, described at one scale
//   3. each kind thinned to its share by spread.h; if one kind has too few, the other fills up
//   4. descriptors of 4 x 4 x 8 gradient histograms, 8-bit
//
// Cost: 1-2 are linear in the pixels, 4 in the features. Results do not depend on `threads`.
#ifndef EGOSIEVE_VISION_FEATURES_FEATURE_EXTRACTOR_H_
#define EGOSIEVE_VISION_FEATURES_FEATURE_EXTRACTOR_H_

#include <cstdint>
#include <opencv2/core.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/features/feature_set.h"

namespace egosieve::vision {

struct FeatureOptions {
  int64_t count = 0;                 // requested; 0: 7000 at 1242 x 375, proportional to the area
  double key_point_share = 0.5;      // of `count`; the rest are corners; [0, 1]
  double contrast_threshold = 0.01;  // of SIFT's extrema, image in [0, 1], over 3 layers; >= 0
  double corner_threshold = 1e-5;    // smallest eigenvalue, image in [0, 1]; >= 0
  double corner_size_pixels = 8;     // diameter used to describe corners; (0, 100]
  int cell_pixels = 24;              // of the grid by which they are spread; positive
  int threads = 2;                   // 1 to 256

  absl::Status Validate() const;
};

// The requested number of features, with count = 0 resolved for an image of this size.
int64_t RequestedFeatureCount(const FeatureOptions& options, cv::Size size);

// grey: CV_8UC1, not empty. An image without texture gives an empty set.
absl::StatusOr<FeatureSet> ExtractFeatures(const cv::Mat& grey, const FeatureOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_FEATURE_EXTRACTOR_H_
