// Point pairs in well-conditioned coordinates: centred in each image and divided by one common
// length, so that distances there are distances in pixels over `scale_pixels` (Hartley, 1997).
//
//   p_i = (x_i - c_i) / s,   c_i = mean of x_i,   s = rms distance from the means, over both images
//
//   F_pixels = T2^T F T1,   H_pixels = T2^-1 H T1,
//   T_i = [ 1/s 0 -c_i.x/s; 0 1/s -c_i.y/s; 0 0 1 ]
//
// Stored as four arrays of floats for scoring. The error of float is under 1e-3 pixels at any image
// size.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct NormalizedPairs {
  std::vector<float> x1, y1, x2, y2;
  Eigen::Matrix3d t1 = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d t2 = Eigen::Matrix3d::Identity();
  double scale_pixels = 1.0;

  int64_t size() const { return static_cast<int64_t>(x1.size()); }
  PointPair pair(int64_t i) const { return {x1[i], y1[i], x2[i], y2[i]}; }
};

// In the order given by `order`, indices into pairs. If all points coincide, s = 1.
NormalizedPairs Normalize(const std::vector<PointPair>& pairs, const std::vector<int64_t>& order);

Eigen::Matrix3d FundamentalInPixels(const Eigen::Matrix3d& f, const NormalizedPairs& pairs);
Eigen::Matrix3d HomographyInPixels(const Eigen::Matrix3d& h, const NormalizedPairs& pairs);

}  // namespace egosieve::vision
