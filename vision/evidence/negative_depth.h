// Depths behind the camera (cheirality): impossible for a static point, usual for a car that pulls
// away.
//
//   s     = d.(x_2 - x_inf)            signed flow along the epipolar line, epipolar_line.h  (N1)
//   var s = 2 sigma^2 + j^T C j + (sigma_f ds/dlog f)^2
//                                      pixel noise in both frames, the rotation's, the lens's (N2)
//   j     = -A x g,  g^T = d^T (dproject/dA)       ds/dw, by a small rotation                (N3)
//   ds/dlog f = -d.(x_inf - c + f (B_xy - A_xy B_3 / A_3) / A_3) + j.dw/dlog f,  B = R e_3   (N4)
//
// C is the covariance of the rotation (relative_pose.h, P5). dw/dlog f and sigma_f (P7) describe
// the error of the focal length: in a sharp turn, a focal length that is too long makes far points
// appear to be behind the camera. A point with z = s / sqrt(var s) below about -3 cannot be static.
// Larger z are weak evidence, because most static points and most movers have s > 0.
//
// No value is given if the pose was not found or the point lies at the point of expansion.
// Reference: Klappstein, Stein & Franke (2006), positive depth constraint.
#pragma once

#include <Eigen/Core>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct SignedFlow {
  bool present = false;
  double along_pixels = 0.0;                            // s
  double deviation_pixels = 0.0;                        // sqrt(var s)
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  // d
};

SignedFlow MeasureSignedFlow(const Pinhole& camera, const RelativePose& pose,
                             const PointPair& pair);

}  // namespace egosieve::vision
