// The distance of a point pair from a motion model of a static scene, in pixels.
//
//   static        |x2 - x1|
//   homography    |x2 - H x1|                                                 transfer error
//   fundamental   with l2 = F x1, l1 = F^T x2, e = x2^T F x1:
//     Sampson        |e| / sqrt(l2_x^2 + l2_y^2 + l1_x^2 + l1_y^2)            first-order distance
//     point to line  |e| / sqrt(l2_x^2 + l2_y^2)                              in the second image
//     (paper)
//
// References: Hartley & Zisserman, 2nd ed., 11.4.3.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/geometry/motion_model_kind.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

enum class EpipolarDistance { kSampson, kPointToLine };

// If the distance is undefined (at an epipole, at infinity), it is 0 for F and infinity for H.
double SampsonDistance(const Eigen::Matrix3d& f, const PointPair& pair);
double PointToLineDistance(const Eigen::Matrix3d& f, const PointPair& pair);
double TransferDistance(const Eigen::Matrix3d& h, const PointPair& pair);

// One per pair. `matrix` is read for homographies and fundamental matrices; kNone gives zeros.
std::vector<double> Residuals(MotionModelKind kind, const Eigen::Matrix3d& matrix,
                              const std::vector<PointPair>& pairs, EpipolarDistance distance);

}  // namespace egosieve::vision
