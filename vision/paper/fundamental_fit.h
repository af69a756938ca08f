// The fundamental matrix of pairs of points, of which some are false matches and some lie on things
// that move by themselves, by OpenCV's RANSAC (USAC): a truncated sum of squares (MSAC; Torr &
// Zisserman, 2000), local optimisation (Chum et al., 2003), dominant planes recognised (Chum et
// al., 2005) and least squares at the end.
//
//   cost(F) = sum_i min(d_i^2 / T^2, 1),   d Sampson's distance, T = 0.25 pixels
//
// All pairs are read; at most 2,000 samples are drawn. Same pairs and seed: same bytes.
//
// It is trusted where at least 0.3 of the pairs lie within 2 pixels of it: only a large share of them
// tells the camera's motion from a thing's.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/base/splitmix.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// A seed for one step of one frame, from the run's seed.
inline uint64_t MixSeed(uint64_t seed, uint64_t frame_index, uint64_t step) {
  uint64_t z = seed;
  for (const uint64_t value : {frame_index, step}) {
    z = kernels::SplitMix(z + kernels::kSplitMixStep + value);
  }
  return z;
}

// The distance of a point pair from the epipolar geometry of a fundamental matrix F, in pixels. With
// l2 = F x1, l1 = F^T x2, e = x2^T F x1:
//
//   Sampson        |e| / sqrt(l2_x^2 + l2_y^2 + l1_x^2 + l1_y^2)            first-order distance
//   point to line  |e| / sqrt(l2_x^2 + l2_y^2)                              in the second image
//
// At an epipole both are 0. Reference: Hartley & Zisserman, 2nd ed., 11.4.3.
double SampsonDistance(const Eigen::Matrix3d& f, const PointPair& pair);
double PointToLineDistance(const Eigen::Matrix3d& f, const PointPair& pair);

struct MotionModel {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // F in pixels, first image to second
  int64_t inlier_count = 0;                              // pairs near the model
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

// Kind kNone with a reason for fewer than 7 pairs of finite coordinates, and for pairs that do not
// determine a matrix: all points of an image on a line, identical, ...
MotionModel FitFundamental(const std::vector<PointPair>& pairs, uint64_t seed);

}  // namespace egosieve::vision
