// Matches between the features of two frames.
//
//   nearest by descriptor (descriptor_search.h), and kept where
//     d1 < ratio d2       the nearest is clearly nearer than the next (Lowe, 2004)
//     mutual              each is the other's nearest
//
// Full search compares all of a kind; windowed search only those within a radius of a predicted
// place, which is faster and, as there are fewer to be mistaken for, finds more true matches. Key
// points and corners are matched apart.
#ifndef EGOSIEVE_VISION_MATCHING_FEATURE_MATCHER_H_
#define EGOSIEVE_VISION_MATCHING_FEATURE_MATCHER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/features/feature_set.h"

namespace egosieve::vision {

struct MatchOptions {
  double ratio = 0.8;                // of distances (not squared), (0, 1]; 1 lets all but ties pass
  double window_radius_pixels = 24;  // of windowed search; positive
  int threads = 2;                   // 1 to 256

  absl::Status Validate() const;
};

struct Match {
  int32_t first = 0;   // index into the first frame's features
  int32_t second = 0;  // into the second's
  float ratio = 0.0F;  // d1 / d2, 0 where there was no second candidate
};

// In increasing order of `first`. InvalidArgument for invalid options.
absl::StatusOr<std::vector<Match>> MatchFeatures(const FeatureSet& first, const FeatureSet& second,
                                                 const MatchOptions& options);

// predicted: where each of the first's features is expected in the second frame, pixels; a place
// that is not finite excludes its feature. InvalidArgument for a wrong number of them.
absl::StatusOr<std::vector<Match>> MatchFeaturesNear(const FeatureSet& first,
                                                     const FeatureSet& second,
                                                     const std::vector<cv::Point2f>& predicted,
                                                     const MatchOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_FEATURE_MATCHER_H_
