// The fundamental matrices of seven point pairs (Hartley & Zisserman, 2nd ed., 11.1.2).
//
//   (SN1) x2^T F x1 = 0 for seven pairs leaves F = t F_a + (1 - t) F_b, the null space of a 7 x 9
//         matrix
//   (SN2) det F = 0 is a cubic in t: one or three real roots, each a solution
//
// The null space is computed by elimination with complete pivoting. A sample whose matrix has rank
// below 7 to relative 1e-9 is degenerate (repeated pairs, collinear points, a rank-deficient
// motion) and is rejected.
#pragma once

#include <Eigen/Core>
#include <array>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct SevenPointSolutions {
  int count = 0;                            // 0: degenerate
  std::array<Eigen::Matrix3d, 3> matrices;  // unit Frobenius norm, rank 2
};

// The coordinates must be of order 1 (normalized_pairs.h).
SevenPointSolutions SolveSevenPoint(const std::array<PointPair, 7>& pairs);

// All real roots of c[3] t^3 + c[2] t^2 + c[1] t + c[0], in increasing order, polished by Newton
// steps; of lower degree where the leading coefficients vanish. Returns their number; 0 for a
// constant.
int RealCubicRoots(const std::array<double, 4>& c, std::array<double, 3>& roots);

// Oriented epipolar constraint (Chum et al., 2004): for a real camera all points of a correct
// sample have the same orientation. False means that F cannot be the motion of all these points.
bool OrientationsAgree(const Eigen::Matrix3d& f, const std::array<PointPair, 7>& pairs);

}  // namespace egosieve::vision
