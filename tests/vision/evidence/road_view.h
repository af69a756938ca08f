// A road with cars on it, seen by a camera that drives straight ahead.
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

inline constexpr double kHeight = 1.4, kTravel = 0.9;  // of the camera, metres; a pair
inline constexpr int kStep = 5;                        // pixels between the points
inline const cv::Size kImage(640, 360);

// m0 of (R2): r is in units of 1 / kTravel, and the horizon is level.
inline const Eigen::Vector3d kLevel(0.0, kTravel / kHeight, 0.0);

enum class What { kRoad, kStanding, kAhead, kOncoming, kHouse, kSky };

struct Seen {
  What what = What::kSky;
  double depth = 1e6;         // metres, at the second frame
  double approach = kTravel;  // metres that it came nearer between the frames
};

// A flat road; at 15 m, from left to right: a parked car, a car ahead at the camera's speed, an
// oncoming one of the same; beyond 60 m houses, above them sky.
inline Seen Look(const Eigen::Vector3d& ray) {
  const double road = ray(1) > 1e-6 ? kHeight / ray(1) : 1e9;
  constexpr double kCar = 15.0, kTop = -0.02;  // of A_y: 0.3 m above the camera
  const double foot = kHeight / kCar;
  if (ray(1) < foot && ray(1) > kTop && road > kCar) {
    if (ray(0) > -0.45 && ray(0) < -0.3) return {What::kStanding, kCar, kTravel};
    if (ray(0) > -0.1 && ray(0) < 0.05) return {What::kAhead, kCar, 0.0};
    if (ray(0) > 0.2 && ray(0) < 0.35) return {What::kOncoming, kCar, 2.0 * kTravel};
  }
  if (road < 60.0) return {What::kRoad, road, kTravel};
  if (ray(1) > -0.3) return {What::kHouse, 60.0, kTravel};
  return {};
}

struct View {
  Pinhole camera = Pinhole::Of(kImage, 420);
  RelativePose pose;
  std::vector<PointPair> pairs;
  std::vector<cv::Point2f> places;
  std::vector<What> what;
};

// The camera moves straight ahead; places are off by `noise` pixels.
inline View MakeView(double noise) {
  View view;
  view.pose.translation = -Eigen::Vector3d::UnitZ();
  view.pose.noise_pixels = std::max(noise, 0.05);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, noise > 0 ? noise : 1e-9);
  for (int y = 2; y < kImage.height; y += kStep) {
    for (int x = 2; x < kImage.width; x += kStep) {
      const Eigen::Vector3d ray = view.camera.Ray(x, y);
      const Seen seen = Look(ray);
      const Eigen::Vector3d before = seen.depth * ray + seen.approach * Eigen::Vector3d::UnitZ();
      const Eigen::Vector2d place = view.camera.Project(before);
      view.pairs.push_back({place(0) + normal(random), place(1) + normal(random),
                            static_cast<double>(x), static_cast<double>(y)});
      view.places.emplace_back(x, y);
      view.what.push_back(seen.what);
    }
  }
  return view;
}

}  // namespace egosieve::vision
