#include "vision/evidence/road_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {
namespace {

// The road is among rays at least kLeastRoadFall below the horizon and near the middle of the image;
// the width grows with the distance below the horizon.
constexpr double kLeastRoadFall = 0.04;
// Least inverse depth of a candidate, in deviations. Blank road and own vehicle have zero flow, and
// a car ahead at equal speed seems infinitely far.
constexpr double kLeastNear = 3.0;
constexpr double kLeastMotionPixels = 0.5, kLeastMotion = 5.0;  // the latter in deviations
constexpr double kNearPlane = 2.5;                              // deviations
// Deviations of m0: roll and pitch in radians, of a car on its springs; speed, a share of it.
constexpr double kRoll = 0.03, kSpeed = 0.15, kPitch = 0.01;
constexpr int kIterations = 4;

// Whether the plane may be fitted to the point.
bool IsCandidate(const InverseDepth& point, double horizon) {
  const double fall = point.ray(1) - horizon;
  return point.valid && point.is_textured && point.moves &&
         point.value > kLeastNear * point.deviation && fall > kLeastRoadFall &&
         std::abs(point.ray(0)) < 0.15 + 1.5 * fall;
}

}  // namespace

std::vector<InverseDepth> InverseDepths(const Pinhole& camera, const RelativePose& pose,
                                        const std::vector<PointPair>& pairs) {
  const RelativePose back = Inverse(pose);
  std::vector<InverseDepth> points(pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& pair = pairs[i];
    InverseDepth& point = points[i];
    point.ray = camera.Ray(pair.x2, pair.y2);
    const EpipolarLine line = LineOf(camera, back.rotation, back.translation, pair.x2, pair.y2);
    if (!line.valid) continue;
    const double s = line.Along({pair.x1, pair.y1});
    if (!line.Reachable(s)) continue;
    point.value = line.InverseDepth(s);
    point.deviation = line.InverseDepthSlope(s) * std::sqrt(2.0) * pose.noise_pixels;
    point.valid = std::isfinite(point.value) && point.deviation > 0.0;
    point.moves = std::hypot(pair.x2 - pair.x1, pair.y2 - pair.y1) >
                  std::max(kLeastMotionPixels, kLeastMotion * pose.noise_pixels);
  }
  return points;
}

RoadPlane FitRoad(const std::vector<InverseDepth>& points, const Eigen::Vector3d& level) {
  const double horizon = -level(2) / level(1);
  const Eigen::Vector3d deviations = level(1) * Eigen::Vector3d(kRoll, kSpeed, kPitch);
  const Eigen::Matrix3d information = deviations.cwiseInverse().cwiseAbs2().asDiagonal();
  RoadPlane road{level};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d normal = information;
    Eigen::Vector3d right = information * level;
    for (const InverseDepth& point : points) {
      if (!IsCandidate(point, horizon)) continue;
      const double at = road.At(point.ray);
      const double deviation = std::hypot(point.deviation, kRoadUnevenness * at);
      if (std::abs(point.value - at) > kNearPlane * deviation) continue;
      const double weight = 1.0 / (deviation * deviation);
      normal += weight * point.ray * point.ray.transpose();
      right += weight * point.value * point.ray;
    }
    const Eigen::Vector3d next = normal.ldlt().solve(right);
    if (!next.allFinite() || !(next(1) > 0.0)) break;
    road.m = next;
  }
  return road;
}

}  // namespace egosieve::vision
