// The fundamental matrix and the homography from point pairs that include false matches and
// independently moving objects, by OpenCV's RANSAC (USAC): a truncated sum of squares (MSAC; Torr &
// Zisserman, 2000), local optimisation (Chum et al., 2003), dominant planes recognised (Chum et
// al., 2005) and least squares at the end.
//
//   cost(model) = sum_i min(d_i^2 / T^2, 1)
//
// d is Sampson's distance for F and the transfer error for H; T is `threshold_pixels`. All pairs
// are read; at most 2,000 samples are drawn. Same pairs and seed: same bytes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// 3 x 3, in pixels, first image to second. Errors: InvalidArgument for fewer than 7 (F)
// or 4 (H) pairs of finite coordinates; NotFound if they do not determine a model (all points of an
// image on a line, identical, ...).
absl::StatusOr<Eigen::Matrix3d> EstimateFundamental(const std::vector<PointPair>& pairs,
                                                    double threshold_pixels, uint64_t seed);
absl::StatusOr<Eigen::Matrix3d> EstimateHomography(const std::vector<PointPair>& pairs,
                                                   double threshold_pixels, uint64_t seed);

}  // namespace egosieve::vision
