#include "vision/evidence/road_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {
namespace {

// Where the road is looked for: rays below the horizon of a level camera, within 45 degrees of the
// middle (less where it is far).
constexpr double kLeastFall = 0.04;
constexpr double kMostAcross = 0.15, kMostHorizon = 0.25;  // of a camera on a car
constexpr double kSlopeChange = 0.03;                      // between frames: a jolt
constexpr double kUneven = 0.08;                           // of r, deviation of a road from a plane
constexpr int kSamples = 150;
constexpr size_t kMostCandidates = 400, kFewestCandidates = 40;
constexpr double kLeastSupport = 0.3, kMostBelow = 0.15;
constexpr double kNearPlane = 2.5;  // deviations

// Of the road's inverse depth: hollows and slopes far ahead; what counts as road; how much nearer
// the lower edge of something may seem that hangs less than a quarter of the camera's height above
// the road: a bumper.
constexpr double kSlack = 0.25, kOnRoad = 0.15, kRaised = 0.35;
constexpr int kRoadBelow = 2;            // points of road that show a foot
constexpr int kMostMissed = 2;           // bad places within a stretch, or none below it
constexpr double kMostRise = 2.5;        // of the camera's height, above it: taller is no vehicle
constexpr double kCarRise = 0.3;         // the same, of a car's roof
constexpr double kLeastFootFall = 0.02;  // of A_y below the horizon: 70 m for a camera on a car
constexpr double kHorizonError = 0.003;  // of A_y
constexpr double kMostLogRatio = 6.0;

double DeviationFrom(const Eigen::Vector3d& m, const InverseDepth& point) {
  const double road = m.dot(point.ray);
  return (point.value - road) / std::hypot(point.deviation, kUneven * road);
}

bool IsPlausible(const Eigen::Vector3d& m, const RoadSlope& last) {
  if (!(m(1) > 0.0)) return false;
  const double across = m(0) / m(1), horizon = -m(2) / m(1);
  if (!(std::abs(across) < kMostAcross && std::abs(horizon) < kMostHorizon)) return false;
  return !last.known || (std::abs(across - last.across) < kSlopeChange &&
                         std::abs(horizon - last.horizon) < kSlopeChange);
}

std::vector<InverseDepth> Candidates(const std::vector<InverseDepth>& points,
                                     const RoadSlope& last) {
  const double horizon = last.known ? last.horizon : 0.0;
  std::vector<InverseDepth> candidates;
  for (const InverseDepth& point : points) {
    const double fall = point.ray(1) - horizon;
    if (point.valid && fall > kLeastFall && std::abs(point.ray(0)) < 0.15 + 1.5 * fall) {
      candidates.push_back(point);
    }
  }
  if (candidates.size() > kMostCandidates) {
    std::vector<InverseDepth> fewer;
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
      const double deviation = std::hypot(point.deviation, kUneven * m.dot(point.ray));
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

// The points in cells of the image; one speaks for its cell.
class Raster {
 public:
  Raster(const std::vector<cv::Point2f>& places, cv::Size image)
      : cell_(std::max(4.0, std::sqrt(static_cast<double>(image.area()) /
                                      static_cast<double>(std::max<size_t>(places.size(), 1))))),
        columns_(static_cast<int>(image.width / cell_) + 1),
        rows_(static_cast<int>(image.height / cell_) + 1),
        points_(static_cast<size_t>(columns_) * rows_, -1) {
    for (size_t i = 0; i < places.size(); ++i) {
      int& point = points_[CellOf(places[i])];
      if (point < 0) point = static_cast<int>(i);
    }
  }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int At(int row, int column) const { return points_[row * columns_ + column]; }
  int SpeakerFor(cv::Point2f place) const { return points_[CellOf(place)]; }

 private:
  int CellOf(cv::Point2f place) const {
    const int row = std::clamp(static_cast<int>(place.y / cell_), 0, rows_ - 1);
    const int column = std::clamp(static_cast<int>(place.x / cell_), 0, columns_ - 1);
    return row * columns_ + column;
  }

  double cell_;
  int columns_, rows_;
  std::vector<int> points_;
};

bool IsAlike(const InverseDepth& a, const InverseDepth& b) {
  return std::abs(a.value - b.value) < 2.5 * std::hypot(a.deviation, b.deviation) +
                                           0.1 * std::max(std::abs(a.value), std::abs(b.value));
}

bool IsOnRoad(const RoadPlane& road, const InverseDepth& point) {
  const double at = road.At(point.ray);
  return at > 0.0 && std::abs(point.value - at) < 2.0 * point.deviation + kOnRoad * at;
}

// As (F2), with Gaussian tails: that roads are not plane is in the deviations already.
double RoadLogRatio(double z) {
  if (!(z < 0.0)) return 0.0;
  return std::min(kMostLogRatio, -std::log(std::erfc(-z / std::sqrt(2.0))));
}

double MedianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// (R3) for a stretch of alike points whose foot is at the ray `foot`.
double FootLogRatio(const RoadPlane& road, const std::vector<InverseDepth>& points,
                    const std::vector<int>& stretch, const Eigen::Vector3d& foot, bool is_tall) {
  const double at = road.At(foot);
  if (!(road.Fall(foot) > kLeastFootFall)) return 0.0;
  std::vector<double> values, deviations;
  for (const int i : stretch) {
    values.push_back(points[i].value);
    deviations.push_back(points[i].deviation);
  }
  const double value = MedianOf(values);
  const double deviation =
      std::hypot(MedianOf(deviations), std::hypot(kUneven * at, kHorizonError * road.m(1)));
  const double sunk = (value - (1.0 - kSlack) * at) / deviation;
  const double raised = ((1.0 + kRaised) * at - value) / deviation;
  return std::max(RoadLogRatio(sunk), is_tall ? 0.0 : RoadLogRatio(raised));
}

// A column of the image from the bottom upwards, in stretches of alike points above road.
class Column {
 public:
  Column(const RoadPlane& road, const std::vector<InverseDepth>& points,
         std::vector<double>& ratios)
      : road_(road), points_(points), ratios_(ratios) {}

  void Take(int row, int i) {
    const InverseDepth& point = points_[i];
    const bool on_road = IsOnRoad(road_, point);
    if (!stretch_.empty()) {
      // Near the horizon all may be road; what is road in truth soon differs from the first.
      if (IsAlike(points_[stretch_.back()], point) &&
          (!on_road || IsAlike(points_[stretch_.front()], point))) {
        stretch_.push_back(i);
        missed_ = 0;
        return;
      }
      if (++missed_ <= kMostMissed) return;  // may be a bad place
      End();
    }
    if (on_road) {
      ++road_below_;
      foot_ = point.ray;
      foot_row_ = row;
    } else if (road_below_ >= kRoadBelow && foot_row_ - row <= kMostMissed + 1) {
      foot_ = 0.5 * (foot_ + point.ray);
      stretch_.push_back(i);
    } else {
      road_below_ = 0;
    }
  }

  void End() {
    // A blank wall or sky behind may seem to go on; it is no part of what has a foot.
    while (!stretch_.empty() && !points_[stretch_.back()].is_textured) stretch_.pop_back();
    const double fall = road_.Fall(foot_);
    const bool is_tall = !stretch_.empty() && Rise(stretch_.back()) > kMostRise * fall;
    // What seems far is alike to what is far and rises behind it.
    while (is_tall && !stretch_.empty() && Rise(stretch_.back()) > kCarRise * fall) {
      stretch_.pop_back();
    }
    if (!stretch_.empty()) {
      const double ratio = FootLogRatio(road_, points_, stretch_, foot_, is_tall);
      for (const int k : stretch_) ratios_[k] = std::max(ratios_[k], ratio);
    }
    stretch_.clear();
    road_below_ = missed_ = 0;
  }

 private:
  double Rise(int i) const { return -road_.Fall(points_[i].ray); }

  const RoadPlane& road_;
  const std::vector<InverseDepth>& points_;
  std::vector<double>& ratios_;
  std::vector<int> stretch_;
  int road_below_ = 0, missed_ = 0, foot_row_ = 0;
  Eigen::Vector3d foot_ = Eigen::Vector3d::Zero();
};

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
  }
  return points;
}

RoadPlane FitRoad(const std::vector<InverseDepth>& points, const RoadSlope& last, uint64_t seed) {
  RoadPlane road;
  const std::vector<InverseDepth> candidates = Candidates(points, last);
  if (candidates.size() < kFewestCandidates) return road;
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
  for (const InverseDepth& point : candidates) {
    const double z = DeviationFrom(road.m, point);
    on += std::abs(z) < kNearPlane ? 1.0 : 0.0;
    below += z < -2.0 * kNearPlane ? 1.0 : 0.0;
  }
  const double count = static_cast<double>(candidates.size());
  road.support = on / count;
  road.found =
      IsPlausible(road.m, last) && road.support >= kLeastSupport && below <= kMostBelow * count;
  return road;
}

std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image) {
  std::vector<double> ratios(points.size(), 0.0);
  if (!road.found) return ratios;
  for (size_t i = 0; i < points.size(); ++i) {
    const double at = road.At(points[i].ray);
    if (!points[i].valid || !(at > 0.0)) continue;
    const double deviation = std::hypot(points[i].deviation, kUneven * at);
    ratios[i] = RoadLogRatio((points[i].value - (1.0 - kSlack) * at) / deviation);
  }
  const Raster raster(places, image);
  std::vector<double> by_foot(points.size(), 0.0);
  for (int column = 0; column < raster.columns(); ++column) {
    Column judged(road, points, by_foot);
    for (int row = raster.rows() - 1; row >= 0; --row) {
      const int i = raster.At(row, column);
      if (i >= 0 && points[i].valid) judged.Take(row, i);
    }
    judged.End();
  }
  for (size_t i = 0; i < points.size(); ++i) {
    const int speaker = raster.SpeakerFor(places[i]);
    if (points[i].valid && points[speaker].valid && IsAlike(points[i], points[speaker])) {
      ratios[i] = std::max(ratios[i], by_foot[speaker]);
    }
  }
  return ratios;
}

}  // namespace egosieve::vision
