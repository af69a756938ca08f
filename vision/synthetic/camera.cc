#include "vision/synthetic/camera.h"

#include <Eigen/Geometry>
#include <cmath>

#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

double SmoothNoise(double t, uint32_t seed) {
  return ValueNoise(static_cast<float>(t), seed) +
         0.4 * ValueNoise(static_cast<float>(2.3 * t), seed + 1);
}

}  // namespace

Eigen::Vector2d Intrinsics::Project(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d u = point.head<2>() / point.z();
  return focal_pixels * (1.0 + radial * u.squaredNorm()) * u + Eigen::Vector2d(centre_x, centre_y);
}

Eigen::Vector2d Intrinsics::Undistort(double x, double y) const {
  const Eigen::Vector2d distorted((x - centre_x) / focal_pixels, (y - centre_y) / focal_pixels);
  if (radial == 0.0) return distorted;
  // Newton's method for r (1 + k r^2) = |distorted|; from this start it converges for both signs of
  // k.
  const double target = distorted.norm();
  if (!(target > 0.0)) return distorted;
  double r = target;
  for (int step = 0; step < 20; ++step) {
    const double change = (r * (1.0 + radial * r * r) - target) / (1.0 + 3.0 * radial * r * r);
    r -= change;
    if (!(std::abs(change) > 1e-15 * r)) break;
  }
  return distorted * (r / target);
}

bool Intrinsics::DistortsUpTo(double pixels) const {
  if (radial >= 0.0) return true;
  // r (1 + k r^2) increases up to r = (-3 k)^-1/2; there it is 2/3 of that r.
  return pixels / focal_pixels < 2.0 / 3.0 / std::sqrt(-3.0 * radial);
}

Pose CameraRig::At(double seconds) const {
  const DriveState state = drive.At(seconds);
  const double s = state.travelled;
  double heave = 0.016 * unevenness * SmoothNoise(s / 3.1, seed + 1);
  double pitch = pitch_radians + 0.006 * unevenness * SmoothNoise(s / 4.3, seed + 2);
  double roll = 0.006 * unevenness * SmoothNoise(s / 5.7, seed + 3);
  double yaw = state.pose.heading_radians + yaw_radians + pan_radians_per_second * seconds +
               0.002 * unevenness * SmoothNoise(s / 6.1, seed + 4);
  for (const double bump : bumps_metres) {
    const double past = (s - bump) / 0.9;
    const double lift = std::exp(-past * past);
    heave += 0.06 * lift;
    pitch += 0.045 * past * lift;
  }
  const double braking = (drive.Speed(seconds - 0.15) - drive.Speed(seconds + 0.15)) / 0.3;
  pitch += 0.004 * braking;
  yaw += sway_radians * SmoothNoise(seconds * 0.7, seed + 5);
  pitch += 0.5 * sway_radians * SmoothNoise(seconds * 0.9, seed + 6);
  roll += 0.35 * sway_radians * SmoothNoise(seconds * 0.8, seed + 7);
  yaw += shake_radians * SmoothNoise(seconds * 4.1, seed + 8);
  pitch += shake_radians * SmoothNoise(seconds * 4.7, seed + 9);
  roll += shake_radians * SmoothNoise(seconds * 3.7, seed + 10);
  // Steps of 0.7 m; a hand at rest does not bob.
  const double step = 2.0 * M_PI * s / 0.7;
  heave += bob_metres * std::sin(step);
  const double aside = 0.7 * bob_metres * std::sin(0.5 * step);

  using Eigen::AngleAxisd;
  Eigen::Matrix3d body_from_camera;
  body_from_camera << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  Pose pose;
  pose.rotation = AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                  AngleAxisd(pitch, Eigen::Vector3d::UnitY()).toRotationMatrix() *
                  AngleAxisd(roll, Eigen::Vector3d::UnitX()).toRotationMatrix() * body_from_camera;
  const double heading = state.pose.heading_radians;
  pose.centre << state.pose.position -
                     aside * Eigen::Vector2d(std::sin(heading), -std::cos(heading)),
      height_metres + heave;
  pose.centre += shake_metres * Eigen::Vector3d(SmoothNoise(seconds * 3.1, seed + 12),
                                                SmoothNoise(seconds * 3.5, seed + 14),
                                                SmoothNoise(seconds * 3.9, seed + 16));
  return pose;
}

Eigen::Vector3d CameraRig::Velocity(double seconds) const {
  constexpr double kStep = 1e-3;
  return (At(seconds + kStep).centre - At(seconds - kStep).centre) / (2.0 * kStep);
}

}  // namespace egosieve::vision
