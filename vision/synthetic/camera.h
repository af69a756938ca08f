// A pinhole camera and its carrier (vehicle or hand).
//
//   (CA1) pixel = (f X/Z + c_x, f Y/Z + c_y), camera axes x right, y down, z forward, pixel centres
//         at integers
//         through a lens with radial distortion k, u = (X/Z, Y/Z):
//         pixel = c + f u (1 + k |u|^2), COLMAP's SIMPLE_RADIAL
//   (CA2) X_world = R X_camera + centre
//
// On a car the camera looks along the heading. The car's springs give smooth heave, pitch and roll
// from the road's unevenness, a jolt at a bump, and pitch under acceleration. In a hand the camera
// sways in all three angles, bobs with the steps, and may shake in all six degrees of freedom a few
// times per second.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/synthetic/drive.h"

namespace egosieve::vision {

struct Intrinsics {
  double focal_pixels = 0.0;
  double centre_x = 0.0;
  double centre_y = 0.0;
  double radial = 0.0;  // k

  // (CA1) of a point in camera axes, Z > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& point) const;
  // u of the ray through a pixel; DistortsUpTo must be true for its distance from the centre.
  Eigen::Vector2d Undistort(double x, double y) const;
  // Whether (CA1) is one to one up to `pixels` from the centre.
  bool DistortsUpTo(double pixels) const;
};

struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // world from camera
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        // in the world
};

struct CameraRig {
  Drive drive;
  double height_metres = 1.45;
  double yaw_radians = 0.0;     // relative to the heading
  double pitch_radians = 0.02;  // downwards
  double unevenness = 1.0;      // of the road; 0: none
  double sway_radians = 0.0;    // amplitude of a hand's rotation
  double bob_metres = 0.0;      // amplitude of steps
  double shake_radians = 0.0;   // amplitude of a hand's tremor about each axis
  double shake_metres = 0.0;    // likewise along each axis
  double pan_radians_per_second = 0.0;
  std::vector<double> bumps_metres;  // arc lengths from the start where the road has a bump
  uint32_t seed = 0;

  Pose At(double seconds) const;
  // Of the centre, metres per second.
  Eigen::Vector3d Velocity(double seconds) const;
};

}  // namespace egosieve::vision
