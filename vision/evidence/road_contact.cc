#include "vision/evidence/road_contact.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace egosieve::vision {
namespace {

// Of the road's inverse depth: hollows and slopes far ahead; what counts as road; how much nearer
// the lower edge of something may seem that hangs less than a quarter of the camera's height above
// the road: a bumper. Without pictures the foot of what is not road is found higher than it is.
constexpr double kSlack = 0.25, kOnRoad = 0.15, kRaised = 0.15, kRaisedUnseen = 0.35;
constexpr double kSeenOnRoad = 1.0, kSeenOffRoad = 3.0;  // of the pictures' log-likelihood ratio
constexpr int kRoadBelow = 2;                            // points of road that show a foot
constexpr size_t kMostMissed = 2;                        // bad places within a stretch
constexpr size_t kMostBetween = 4;                       // places between the road and the stretch
constexpr int kFewestAlike = 2;    // places of a stretch that are seen not to be road
constexpr double kMostRise = 2.5;  // of the camera's height, above it: taller is no vehicle
constexpr double kCarRise = 0.3, kVanRise = 0.5;  // the same, of their roofs
constexpr double kLeastFootFall = 0.02;  // of A_y below the horizon: 70 m for a camera on a car
constexpr double kHorizonError = 0.003;  // of A_y
constexpr double kMostLogRatio = 6.0;
constexpr double kSameDepth = 0.05;  // of r, within a surface

// What its foot says of a point: that it is too far for it, or too near.
struct FootRatios {
  bool judged = false;
  double sunk = 0.0;
  double raised = 0.0;
};

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

enum class Ground { kRoad, kUnclear, kOff };

Ground GroundOf(const RoadPlane& road, const InverseDepth& point) {
  if (point.against_road < -kSeenOnRoad) return Ground::kRoad;
  const double at = road.At(point.ray);
  const bool fits = at > 0.0 && std::abs(point.value - at) < 2.0 * point.deviation + kOnRoad * at;
  if (!(point.against_road < kSeenOffRoad)) {
    return fits && std::isinf(point.against_road) ? Ground::kRoad : Ground::kOff;
  }
  return fits ? Ground::kRoad : Ground::kUnclear;
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

// A column of the image from the bottom upwards: what stands above road, and whether its depth is
// that of its foot.
class Column {
 public:
  Column(const RoadPlane& road, const std::vector<InverseDepth>& points, std::vector<int> column,
         const std::vector<Ground>& grounds, std::vector<FootRatios>& ratios)
      : road_(road), points_(points), column_(std::move(column)), ratios_(ratios) {
    for (const int i : column_) ground_.push_back(grounds[i]);
  }

  void Judge() {
    int road_below = 0;
    size_t foot = 0;
    for (size_t k = 0; k < column_.size();) {
      if (ground_[k] == Ground::kRoad) {
        ++road_below;
        foot = k++;
      } else if (road_below < kRoadBelow || k - foot > kMostBetween) {
        road_below = 0;
        ++k;
      } else if (ground_[k] == Ground::kUnclear) {
        ++k;
      } else {
        k = JudgeAbove(foot, k);
        road_below = 0;
      }
    }
  }

 private:
  const InverseDepth& At(size_t k) const { return points_[column_[k]]; }
  double Rise(size_t k) const { return -road_.Fall(At(k).ray); }

  // Places in the column of the points from `first` upwards that are alike.
  std::vector<size_t> StretchFrom(size_t first) const {
    std::vector<size_t> stretch = {first};
    for (size_t k = first + 1; k < column_.size() && k - stretch.back() <= kMostMissed + 1; ++k) {
      // Near the horizon all may be road; what is road in truth soon differs from the first.
      if (IsAlike(At(stretch.back()), At(k)) &&
          (ground_[k] != Ground::kRoad || IsAlike(At(first), At(k)))) {
        stretch.push_back(k);
      }
    }
    return stretch;
  }

  // Road is last seen at `foot`, and first seen not to be at `off`. The place in the column behind
  // what was judged.
  size_t JudgeAbove(size_t foot, size_t off) {
    // Flow is smooth: between the road and what stands on it lie places that belong to neither.
    std::vector<size_t> stretch;
    for (size_t k = foot + 1; k < column_.size() && k <= off + kMostBetween; ++k) {
      if (ground_[k] == Ground::kRoad) break;
      std::vector<size_t> other = StretchFrom(k);
      if (other.size() > stretch.size()) stretch = std::move(other);
    }
    const auto seen = std::count_if(stretch.begin(), stretch.end(),
                                    [&](size_t k) { return ground_[k] == Ground::kOff; });
    if (seen < kFewestAlike) return off + 1;
    const size_t behind = stretch.back() + 1;
    // A blank wall or sky behind may seem to go on; it is no part of what has a foot.
    while (!stretch.empty() && !At(stretch.back()).is_textured) stretch.pop_back();
    if (stretch.empty()) return behind;
    const double fall = road_.Fall(At(foot).ray);
    const bool is_tall = Rise(stretch.back()) > kMostRise * fall;
    // What seems far is alike to what is far and rises behind it.
    while (is_tall && !stretch.empty() && Rise(stretch.back()) > kCarRise * fall) {
      stretch.pop_back();
    }
    if (stretch.empty()) return behind;
    std::vector<double> values, deviations;
    for (const size_t k : stretch) {
      values.push_back(At(k).value);
      deviations.push_back(At(k).deviation);
    }
    const double value = MedianOf(values);
    const FootRatios ratios =
        RatiosOf(value, MedianOf(deviations), At(foot).ray, At(stretch.front()).ray, is_tall,
                 std::isfinite(At(off).against_road));
    for (size_t k = foot + 1; k < stretch.front(); ++k) {
      const double own = At(k).value;
      if (std::abs(own - value) < std::abs(own - road_.At(At(k).ray))) stretch.push_back(k);
    }
    for (const size_t k : stretch) {
      ratios_[column_[k]] = ratios;
      if (Rise(k) > kVanRise * fall) ratios_[column_[k]].sunk = 0.0;
    }
    return behind;
  }

  // (R3); the foot lies between the last ray of the road and the first above.
  FootRatios RatiosOf(double value, double deviation, const Eigen::Vector3d& below,
                      const Eigen::Vector3d& above, bool is_tall, bool is_seen) const {
    if (!(road_.Fall(above) > kLeastFootFall)) return {};
    const double furthest = road_.At(above);
    const double middle = 0.5 * (road_.At(below) + furthest);
    const auto total = [&](double at) {
      return std::hypot(deviation, std::hypot(kRoadUnevenness * at, kHorizonError * road_.m(1)));
    };
    const double sunk = (value - (1.0 - kSlack) * furthest) / total(furthest);
    const double raised =
        ((1.0 + (is_seen ? kRaised : kRaisedUnseen)) * middle - value) / total(middle);
    return {true, RoadLogRatio(sunk), is_tall ? 0.0 : RoadLogRatio(raised)};
  }

  const RoadPlane& road_;
  const std::vector<InverseDepth>& points_;
  std::vector<int> column_;
  std::vector<Ground> ground_;
  std::vector<FootRatios>& ratios_;
};

// Sets of alike points in neighbouring cells.
class Objects {
 public:
  explicit Objects(size_t points) : parent_(points) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(int i, int k) {
    const int a = Find(i), b = Find(k);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

bool IsOneSurface(const InverseDepth& a, const InverseDepth& b) {
  return std::abs(a.value - b.value) <
         1.5 * std::hypot(a.deviation, b.deviation) +
             kSameDepth * std::max(std::abs(a.value), std::abs(b.value));
}

// What some columns of an object say holds for all of it: the mean of `raised` over its points that
// were judged. Not so for `sunk`: what seems far is of one depth with all that is far.
std::vector<double> RaisedByObject(const Raster& raster, const std::vector<InverseDepth>& points,
                                   const std::vector<Ground>& grounds,
                                   const std::vector<FootRatios>& ratios) {
  Objects objects(points.size());
  const auto is_part = [&](int i) {
    return i >= 0 && points[i].valid && grounds[i] != Ground::kRoad;
  };
  for (int row = 0; row < raster.rows(); ++row) {
    for (int column = 0; column < raster.columns(); ++column) {
      const int i = raster.At(row, column);
      if (!is_part(i)) continue;
      const int right = column + 1 < raster.columns() ? raster.At(row, column + 1) : -1;
      const int below = row + 1 < raster.rows() ? raster.At(row + 1, column) : -1;
      for (const int k : {right, below}) {
        if (is_part(k) && IsOneSurface(points[i], points[k])) objects.Join(i, k);
      }
    }
  }
  std::vector<double> sums(points.size(), 0.0), counts(points.size(), 0.0);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!ratios[i].judged) continue;
    const int object = objects.Find(static_cast<int>(i));
    sums[object] += ratios[i].raised;
    counts[object] += 1.0;
  }
  std::vector<double> means(points.size(), 0.0);
  for (size_t i = 0; i < points.size(); ++i) {
    const int object = objects.Find(static_cast<int>(i));
    if (counts[object] > 0.0) means[i] = sums[object] / counts[object];
  }
  return means;
}

// Where a point of the road that is now at `place` was in the first frame; nothing above the
// horizon.
std::optional<cv::Point2f> PlaceOfRoadBefore(const RoadPlane& road, const Pinhole& camera,
                                             const RelativePose& back, cv::Point2f place) {
  const Eigen::Vector3d ray = camera.Ray(place.x, place.y);
  const double inverse_depth = road.At(ray);
  const Eigen::Vector3d point = back.rotation * ray + inverse_depth * back.translation;
  if (!(inverse_depth > 0.0) || !(point(2) > 0.1)) return std::nullopt;
  const Eigen::Vector2d before = camera.Project(point);
  return cv::Point2f(static_cast<float>(before(0)), static_cast<float>(before(1)));
}

}  // namespace

void CompareWithRoad(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                     const PhotometricSupport& pictures, const std::vector<PointPair>& pairs,
                     std::vector<InverseDepth>& points) {
  const RelativePose back = Inverse(pose);
  const PhotometricSupport reversed = pictures.Reversed();
  for (size_t i = 0; i < points.size(); ++i) {
    if (!points[i].valid) continue;
    const cv::Point2f now(static_cast<float>(pairs[i].x2), static_cast<float>(pairs[i].y2));
    const cv::Point2f before(static_cast<float>(pairs[i].x1), static_cast<float>(pairs[i].y1));
    const std::optional<cv::Point2f> as_road = PlaceOfRoadBefore(road, camera, back, now);
    if (!as_road) continue;
    points[i].against_road = reversed.SignedLogRatio(now, before, *as_road).value_or(0.0);
  }
}

std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image) {
  std::vector<double> ratios(points.size(), 0.0);
  if (!road.found) return ratios;
  std::vector<Ground> grounds(points.size(), Ground::kUnclear);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!points[i].valid) continue;
    grounds[i] = GroundOf(road, points[i]);
    const double at = road.At(points[i].ray);
    if (!(at > 0.0)) continue;
    const double deviation = std::hypot(points[i].deviation, kRoadUnevenness * at);
    const double below = RoadLogRatio((points[i].value - (1.0 - kSlack) * at) / deviation);
    ratios[i] = std::min(below, std::max(0.0, points[i].against_road));
  }
  const Raster raster(places, image);
  std::vector<FootRatios> by_foot(points.size());
  for (int column = 0; column < raster.columns(); ++column) {
    std::vector<int> upwards;
    for (int row = raster.rows() - 1; row >= 0; --row) {
      const int i = raster.At(row, column);
      if (i >= 0 && points[i].valid) upwards.push_back(i);
    }
    Column(road, points, std::move(upwards), grounds, by_foot).Judge();
  }
  const std::vector<double> raised = RaisedByObject(raster, points, grounds, by_foot);
  for (size_t i = 0; i < points.size(); ++i) {
    const int speaker = raster.SpeakerFor(places[i]);
    if (!points[i].valid || !points[speaker].valid || !IsAlike(points[i], points[speaker]))
      continue;
    const FootRatios& foot = by_foot[speaker];
    ratios[i] = std::max({ratios[i], foot.sunk, foot.raised, raised[speaker]});
  }
  return ratios;
}

}  // namespace egosieve::vision
