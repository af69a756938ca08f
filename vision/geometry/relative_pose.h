// The camera's rotation and its direction of travel between two pictures.
//
//   X_2 = R X_1 + t,  |t| = 1
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <concepts>

namespace egosieve::vision {

struct RelativePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // R
  Eigen::Vector3d translation = Eigen::Vector3d::UnitZ();  // t
  double noise_pixels = 0.0;                               // deviation of a static place
};

// From the second picture to the first, of a pose or what is derived from it.
template <std::derived_from<RelativePose> Pose>
Pose Inverse(const Pose& pose) {
  Pose inverse = pose;
  inverse.rotation = pose.rotation.transpose();
  inverse.translation = -(inverse.rotation * pose.translation);
  return inverse;
}

// Matrix of the cross product with v.
inline Eigen::Matrix3d CrossProduct(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v(2), v(1), v(2), 0, -v(0), -v(1), v(0), 0;
  return m;
}

// exp of CrossProduct(w) (Rodrigues).
inline Eigen::Matrix3d RotationOf(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (!(angle > 1e-12)) return Eigen::Matrix3d::Identity() + CrossProduct(w);
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

}  // namespace egosieve::vision
