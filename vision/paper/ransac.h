// Robust estimation of the fundamental matrix and of the homography from point pairs that include
// false matches and independently moving objects: RANSAC with truncated squares (MSAC; Torr &
// Zisserman, 2000), local optimisation (Chum et al., 2003) and early stop.
//
//   cost(model) = sum_i min(d_i^2 / T^2, 1)                                                (RS1)
//   iterations until  (1 - w^m)^k <= 0.0001,   w = share of inliers, m = sample size   (RS2)
//
// d is Sampson's distance for F and the transfer error for H; T is the threshold. Each new best
// model is refined by a few reweighted least-squares steps with Tukey's weights and a shrinking
// radius; each step is kept only if it lowers (RS1). A sample is rejected if it is degenerate, if
// two of its points are closer than 2 pixels, or (F) if the orientations of its
// points disagree. A model is first tested on a random part of the pairs, and on all pairs unless
// it is clearly worse there than the best so far.
//
// Same pairs and seed: same bytes. Cost: an iteration is at most linear in the pairs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct RansacOptions {
  double threshold_pixels = 1.0;  // T; positive
  uint64_t seed = 1;
};

struct RansacResult {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // pixels, first image to second
  int64_t inlier_count = 0;                              // of the pairs used
  int iterations = 0;                                    // at most 2,000
};

// Errors: InvalidArgument for fewer than 7 (F) or 4 (H) pairs; NotFound if
// no sample gives a model (all points collinear, identical, ...).
absl::StatusOr<RansacResult> EstimateFundamental(const std::vector<PointPair>& pairs,
                                                 const RansacOptions& options);
absl::StatusOr<RansacResult> EstimateHomography(const std::vector<PointPair>& pairs,
                                                const RansacOptions& options);

}  // namespace egosieve::vision
