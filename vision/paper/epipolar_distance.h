// The distance of a point pair from the epipolar geometry of a fundamental matrix F, in pixels. With
// l2 = F x1, l1 = F^T x2, e = x2^T F x1:
//
//   Sampson        |e| / sqrt(l2_x^2 + l2_y^2 + l1_x^2 + l1_y^2)            first-order distance
//   point to line  |e| / sqrt(l2_x^2 + l2_y^2)                              in the second image
//
// At an epipole both are 0. Reference: Hartley & Zisserman, 2nd ed., 11.4.3.
#pragma once

#include <Eigen/Core>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

double SampsonDistance(const Eigen::Matrix3d& f, const PointPair& pair);
double PointToLineDistance(const Eigen::Matrix3d& f, const PointPair& pair);

}  // namespace egosieve::vision
