#include "vision/evidence/road_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {
namespace {

// The road is searched for among rays at least kLeastRoadFall below the horizon and near the middle
// of the image; the width grows with the distance below the horizon.
constexpr double kLeastRoadFall = 0.04;
constexpr double kMostAcross = 0.15, kMostHorizon = 0.25;  // of a camera on a car
constexpr double kSlopeChange = 0.03;                      // between frames: a jolt
// Least inverse depth of a candidate, in deviations. Blank road and own vehicle have zero flow, and
// a car ahead at equal speed seems infinitely far.
constexpr double kLeastNear = 3.0;
constexpr double kLeastMotionPixels = 0.5, kLeastMotion = 5.0;  // the latter in deviations
constexpr int kSamples = 150;
constexpr size_t kMostCandidates = 400, kFewestCandidates = 40;
constexpr double kLeastSupport = 0.3, kMostBelow = 0.3;  // the latter of those on the plane
constexpr double kNearPlane = 2.5;                       // deviations

double DeviationFrom(const Eigen::Vector3d& m, const InverseDepth& point) {
  const double road = m.dot(point.ray);
  return (point.value - road) / std::hypot(point.deviation, kRoadUnevenness * road);
}

bool IsPlausible(const Eigen::Vector3d& m, const RoadSlope& last) {
  if (!(m(1) > 0.0)) return false;
  const RoadSlope slope = RoadPlane{true, m}.slope();
  if (!(std::abs(slope.across) < kMostAcross && std::abs(slope.horizon) < kMostHorizon)) {
    return false;
  }
  return !last.known || AreAlike(slope, last);
}

// Indices of the points that the plane is fitted to.
std::vector<size_t> Candidates(const std::vector<InverseDepth>& points, const RoadSlope& last) {
  const double horizon = last.known ? last.horizon : 0.0;
  std::vector<size_t> candidates;
  for (size_t i = 0; i < points.size(); ++i) {
    const InverseDepth& point = points[i];
    const double fall = point.ray(1) - horizon;
    if (point.valid && point.is_textured && point.moves &&
        point.value > kLeastNear * point.deviation && fall > kLeastRoadFall &&
        std::abs(point.ray(0)) < 0.15 + 1.5 * fall) {
      candidates.push_back(i);
    }
  }
  if (candidates.size() > kMostCandidates) {
    std::vector<size_t> fewer;
    for (size_t i = 0; i < kMostCandidates; ++i) {
      fewer.push_back(candidates[i * candidates.size() / kMostCandidates]);
    }
    candidates = std::move(fewer);
  }
  return candidates;
}

double Score(const Eigen::Vector3d& m, const std::vector<InverseDepth>& points) {
  double score = 0.0;
  for (const InverseDepth& point : points) {
    const double z = DeviationFrom(m, point) / kNearPlane;
    score += std::max(0.0, 1.0 - z * z);
  }
  return score;
}

Eigen::Vector3d Refine(Eigen::Vector3d m, const std::vector<InverseDepth>& points) {
  for (int iteration = 0; iteration < 4; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const InverseDepth& point : points) {
      const double z = DeviationFrom(m, point);
      if (std::abs(z) > kNearPlane) continue;
      const double deviation = std::hypot(point.deviation, kRoadUnevenness * m.dot(point.ray));
      const double weight = 1.0 / (deviation * deviation);
      normal += weight * point.ray * point.ray.transpose();
      right += weight * point.value * point.ray;
    }
    const Eigen::Vector3d next = normal.ldlt().solve(right);
    if (!next.allFinite()) return m;
    m = next;
  }
  return m;
}

}  // namespace

bool AreAlike(const RoadSlope& a, const RoadSlope& b) {
  return std::abs(a.across - b.across) < kSlopeChange &&
         std::abs(a.horizon - b.horizon) < kSlopeChange;
}

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

RoadPlane FitRoad(const std::vector<InverseDepth>& points, const RoadSlope& last, uint64_t seed,
                  const IsSeenOffPlane& is_seen_off) {
  RoadPlane road;
  const std::vector<size_t> indices = Candidates(points, last);
  if (indices.size() < kFewestCandidates) return road;
  std::vector<InverseDepth> candidates;
  for (const size_t i : indices) candidates.push_back(points[i]);
  std::mt19937_64 random(seed);
  double best = 0.0;
  for (int sample = 0; sample < kSamples; ++sample) {
    Eigen::Matrix3d rays;
    Eigen::Vector3d values;
    for (int k = 0; k < 3; ++k) {
      const InverseDepth& point = candidates[random() % candidates.size()];
      rays.row(k) = point.ray.transpose();
      values(k) = point.value;
    }
    if (!(std::abs(rays.determinant()) > 1e-4)) continue;
    const Eigen::Vector3d m = rays.inverse() * values;
    if (!IsPlausible(m, last)) continue;
    const double score = Score(m, candidates);
    if (score > best) {
      best = score;
      road.m = m;
    }
  }
  if (!(best > 0.0)) return road;
  road.m = Refine(road.m, candidates);
  double on = 0.0, below = 0.0;
  for (const size_t i : indices) {
    const double z = DeviationFrom(road.m, points[i]);
    on += std::abs(z) < kNearPlane ? 1.0 : 0.0;
    const bool is_below = z < -2.0 * kNearPlane && (is_seen_off == nullptr || is_seen_off(road, i));
    below += is_below ? 1.0 : 0.0;
  }
  const double count = static_cast<double>(candidates.size());
  road.support = on / count;
  road.found =
      IsPlausible(road.m, last) && road.support >= kLeastSupport && below <= kMostBelow * on;
  return road;
}

}  // namespace egosieve::vision
