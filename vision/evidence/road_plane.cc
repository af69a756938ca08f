#include "vision/evidence/road_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

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

// The epipolar line of a point of the first frame in the second, parametrised by depth.
//
//   A = R K^-1 x_1,  x_inf = project(A)                                the point at infinity
//   x_2(r) = project(A + r t)                                          r = |t| / Z_1, inverse depth
//   d = dx_2/dr / |dx_2/dr| at r = 0                                   the line's direction
//   s = d.(x_2 - x_inf)                                                signed flow along it, pixels
//   r = s A_3 / (G - s t_3),   G = f |t_xy - t_3 A_xy / A_3|           its inverse
//   dr/ds = A_3 G / (G - s t_3)^2
//
// A static point has r > 0, so s > 0. s < 0 belongs to a depth behind the camera: driving forward,
// it is flow towards the point of expansion.
struct EpipolarLine {
  Eigen::Vector3d ray;        // A
  Eigen::Vector2d infinity;   // x_inf
  Eigen::Vector2d direction;  // d
  double gain = 0.0;          // G
  double forward = 0.0;       // t_3

  // False where the point is at the point of expansion or behind the second camera.
  bool valid = false;

  double Along(const Eigen::Vector2d& x2) const { return direction.dot(x2 - infinity); }
  double InverseDepth(double s) const { return s * ray(2) / (gain - s * forward); }
  double InverseDepthSlope(double s) const {
    const double remaining = gain - s * forward;
    return ray(2) * gain / (remaining * remaining);
  }
  // Whether some depth in (-infinity, infinity) gives this s, short of the point of expansion.
  bool Reachable(double s) const { return gain - s * forward > 0.02 * gain; }
};

// t need not have unit length.
EpipolarLine LineOf(const Pinhole& camera, const Eigen::Matrix3d& rotation,
                    const Eigen::Vector3d& t, double x1, double y1) {
  EpipolarLine line;
  line.ray = rotation * camera.Ray(x1, y1);
  line.forward = t(2);
  if (!(line.ray(2) > 0.1)) return line;
  line.infinity = camera.Project(line.ray);
  const Eigen::Vector2d slope =
      camera.focal_pixels * (t.head<2>() - line.ray.head<2>() * (t(2) / line.ray(2)));
  line.gain = slope.norm();
  // At the point of expansion the direction of the line is undefined.
  if (!(line.gain > 1e-9)) return line;
  line.direction = slope / line.gain;
  line.valid = true;
  return line;
}

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
