// Where points at rest lie in two pictures of a camera without distortion.
//
//   x2^T F x1 = 0,  F = K^-T [t]x R2^T R1 K^-1,  t = R2^T (centre1 - centre2)
#ifndef EGOSIEVE_TESTS_VISION_SYNTHETIC_FUNDAMENTAL_MATRIX_H_
#define EGOSIEVE_TESTS_VISION_SYNTHETIC_FUNDAMENTAL_MATRIX_H_

#include <Eigen/Core>
#include <Eigen/LU>

#include "vision/synthetic/camera.h"

namespace egosieve::vision {

// Zero if the centres coincide.
inline Eigen::Matrix3d FundamentalMatrix(const Intrinsics& intrinsics, const Pose& first,
                                         const Pose& second) {
  const Eigen::Vector3d t = second.rotation.transpose() * (first.centre - second.centre);
  Eigen::Matrix3d cross;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  const Eigen::Matrix3d k_inverse = intrinsics.Matrix().inverse();
  return k_inverse.transpose() * cross * second.rotation.transpose() * first.rotation * k_inverse;
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_TESTS_VISION_SYNTHETIC_FUNDAMENTAL_MATRIX_H_
