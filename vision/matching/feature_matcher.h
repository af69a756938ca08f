// Matches between the features of two frames.
//
//   the nearest by descriptor (descriptor_search.h), kept where
//     d1 < ratio d2       the nearest is clearly nearer than the second (Lowe, 2004)
//     mutual              each is the other's nearest
//
// Full search compares all features of a kind. Windowed search compares only those within a radius
// of a predicted position. This is faster, and it finds more true matches, since there are fewer
// features to be confused with. Key points and corners are matched separately.
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
  double ratio = 0.8;                // of distances (not squared), (0, 1]; 1 rejects only ties
  double window_radius_pixels = 24;  // of windowed search; positive
  int threads = 2;                   // 1 to 256

  absl::Status Validate() const;
};

struct Match {
  int32_t first = 0;   // index into the first frame's features
  int32_t second = 0;  // index into the second frame's features
  float ratio = 0.0F;  // d1 / d2; 0 without a second candidate
};

// In increasing order of `first`. InvalidArgument for invalid options.
absl::StatusOr<std::vector<Match>> MatchFeatures(const FeatureSet& first, const FeatureSet& second,
                                                 const MatchOptions& options);

// predicted: the expected position in the second frame, in pixels, of each feature of the first. A
// position that is not finite excludes its feature. InvalidArgument for a wrong number of
// positions.
absl::StatusOr<std::vector<Match>> MatchFeaturesNear(const FeatureSet& first,
                                                     const FeatureSet& second,
                                                     const std::vector<cv::Point2f>& predicted,
                                                     const MatchOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_FEATURE_MATCHER_H_
