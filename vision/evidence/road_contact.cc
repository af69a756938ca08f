#include "vision/evidence/road_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "vision/evidence/for_each_point.h"
#include "vision/evidence/surfaces.h"

namespace egosieve::vision {
namespace {

// Of the road's inverse depth: hollows and slopes far ahead; what counts as road; how much nearer
// the lower edge of something may seem that hangs less than a quarter of the camera's height above
// the road: a bumper. Without pictures the foot of what is not road is found higher than it is.
constexpr double kSlack = 0.25, kOnRoad = 0.15, kRaised = 0.15, kRaisedUnseen = 0.35;
constexpr double kSeenOnRoad = 1.0, kSeenOffRoad = 3.0;  // of the pictures' log-likelihood ratio
constexpr int kRoadBelow = 2;                            // points of road that show a foot
constexpr int kMostMissed = 2;                           // cells without a place, within a stretch
constexpr int kMostBetween = 4;                          // cells between the road and the stretch
constexpr int kFewestAlike = 2;  // places of a stretch that are seen not to be road
// Of a stretch that is more than what flow carries over the road.
constexpr size_t kEnoughPlaces = 3;
constexpr double kEnoughRise = 0.3;  // of the camera's height
constexpr double kSureRoad = 5.0;    // deviations by which a road is nearer than infinity
constexpr double kMostRise = 2.5;    // of the camera's height, above it: taller is no vehicle
constexpr double kCarRise = 0.3, kVanRise = 0.5;  // the same, of their roofs
constexpr double kLeastFootFall = 0.02;  // of A_y below the horizon: 70 m for a camera on a car
constexpr double kHorizonError = 0.003;  // of A_y
constexpr double kMostLogRatio = 6.0;
// Of a surface: the columns that must be judged for what they say to count in full; what many of
// them say counts more, up to kMostWeight; and its rise above the foot, as kMostRise.
constexpr double kEnoughColumns = 0.5, kMostWeight = 1.5, kSurfaceRise = 1.5;

// What its foot says of a point: that it is too far for it, or too near.
struct FootRatios {
  bool judged = false;
  double sunk = 0.0;
  double raised = 0.0;
  double fall = 0.0;  // of the foot, A_y below the horizon
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
  // feet: null without pictures.
  Column(const RoadPlane& road, const std::vector<InverseDepth>& points,
         const std::vector<cv::Point2f>& places, const std::vector<Ground>& grounds,
         const FootSearch* feet, std::vector<FootRatios>& ratios)
      : road_(road),
        points_(points),
        places_(places),
        grounds_(grounds),
        feet_(feet),
        ratios_(ratios) {}

  // The next point upwards, in the raster's cell `height`, counted from below.
  void Add(int point, int height) {
    column_.push_back(point);
    ground_.push_back(grounds_[point]);
    height_.push_back(height);
  }

  void Judge() {
    int road_below = 0;
    size_t foot = 0;
    for (size_t k = 0; k < column_.size();) {
      if (ground_[k] == Ground::kRoad) {
        ++road_below;
        foot = k++;
      } else if (road_below < kRoadBelow || Cells(foot, k) > kMostBetween) {
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
  // Places may be missing in between.
  int Cells(size_t lower, size_t upper) const { return height_[upper] - height_[lower]; }
  bool IsSureRoad(size_t k) const {
    return ground_[k] == Ground::kRoad && road_.At(At(k).ray) > kSureRoad * At(k).deviation;
  }

  // Median of r and its deviation over places in the column.
  InverseDepth MiddleOf(const std::vector<size_t>& stretch) const {
    std::vector<double> values, deviations;
    for (const size_t k : stretch) {
      values.push_back(At(k).value);
      deviations.push_back(At(k).deviation);
    }
    InverseDepth middle;
    middle.value = MedianOf(values);
    middle.deviation = MedianOf(deviations);
    return middle;
  }

  // Places in the column of the points from `first` upwards that are alike their mean: flow goes
  // over smoothly from one thing to the next, and a chain of neighbours goes with it.
  std::vector<size_t> StretchFrom(size_t first) const {
    std::vector<size_t> stretch = {first};
    InverseDepth mean = At(first);
    for (size_t k = first + 1; k < column_.size() && Cells(stretch.back(), k) <= kMostMissed + 1;
         ++k) {
      if (k > first + 1 && IsSureRoad(k) && IsSureRoad(k - 1)) break;
      // Near the horizon all may be road; what is road in truth soon differs from the first.
      if (!IsAlike(mean, At(k))) continue;
      if (ground_[k] == Ground::kRoad && !IsAlike(At(first), At(k))) continue;
      stretch.push_back(k);
      const double share = 1.0 / static_cast<double>(stretch.size());
      mean.value += share * (At(k).value - mean.value);
      mean.deviation += share * (At(k).deviation - mean.deviation);
    }
    return stretch;
  }

  // The first stretch from above `foot` on that is more than what flow carries over the road, which
  // is last seen there and first seen to end at `off`; else the longest.
  std::vector<size_t> StretchAbove(size_t foot, size_t off) const {
    const double least_rise = kEnoughRise * road_.Fall(At(foot).ray);
    std::vector<size_t> longest;
    for (size_t k = foot + 1; k < column_.size() && Cells(off, k) <= kMostBetween; ++k) {
      if (ground_[k] == Ground::kRoad) break;
      std::vector<size_t> stretch = StretchFrom(k);
      const bool is_enough = stretch.size() >= kEnoughPlaces &&
                             Rise(stretch.back()) - Rise(stretch.front()) >= least_rise;
      if (is_enough) return stretch;
      if (stretch.size() > longest.size()) longest = std::move(stretch);
    }
    return longest;
  }

  // The place in the column behind what was judged.
  size_t JudgeAbove(size_t foot, size_t off) {
    std::vector<size_t> stretch = StretchAbove(foot, off);
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
    const InverseDepth middle = MiddleOf(stretch);
    FootRatios ratios;
    ratios.judged = road_.Fall(At(stretch.front()).ray) > kLeastFootFall;
    ratios.fall = fall;
    if (ratios.judged) {
      ratios.sunk = Sunk(middle, At(stretch.front()).ray);
      if (!is_tall) SetRaised(middle, foot, off, stretch, ratios);
    }
    for (size_t k = foot + 1; k < stretch.front(); ++k) {
      const double own = At(k).value;
      if (std::abs(own - middle.value) < std::abs(own - road_.At(At(k).ray))) stretch.push_back(k);
    }
    for (const size_t k : stretch) {
      ratios_[column_[k]] = ratios;
      if (Rise(k) > kVanRise * fall) ratios_[column_[k]].sunk = 0.0;
    }
    return behind;
  }

  // Of r less what the road has at a foot, `at`.
  double Deviation(const InverseDepth& middle, double at) const {
    return std::hypot(middle.deviation,
                      std::hypot(kRoadUnevenness * at, kHorizonError * road_.m(1)));
  }

  // (R3); the foot lies between the last ray of the road and the first above.
  double Sunk(const InverseDepth& middle, const Eigen::Vector3d& above) const {
    const double furthest = road_.At(above);
    return RoadLogRatio((middle.value - (1.0 - kSlack) * furthest) / Deviation(middle, furthest));
  }
  void SetRaised(const InverseDepth& middle, size_t foot, size_t off,
                 const std::vector<size_t>& stretch, FootRatios& ratios) const {
    const double furthest = road_.At(At(stretch.front()).ray);
    if (!(middle.value > furthest + Deviation(middle, furthest))) return;
    double at = 0.5 * (road_.At(At(foot).ray) + furthest);
    if (feet_ != nullptr) {
      const cv::Point2f below(0.0f, 2.0f);  // the last place of the road may be half off it
      const Eigen::Vector3d lowest =
          feet_->LowestFoot(places_[column_[stretch[stretch.size() / 2]]],
                            places_[column_[foot]] + below, middle.value);
      at = road_.At(lowest);
      ratios.fall = road_.Fall(lowest);
    }
    const bool is_seen = std::isfinite(At(off).against_road);
    const double nearest = (1.0 + (is_seen ? kRaised : kRaisedUnseen)) * at;
    ratios.raised = RoadLogRatio((nearest - middle.value) / Deviation(middle, at));
  }

  const RoadPlane& road_;
  const std::vector<InverseDepth>& points_;
  const std::vector<cv::Point2f>& places_;
  const std::vector<Ground>& grounds_;
  const FootSearch* feet_;
  std::vector<FootRatios>& ratios_;
  std::vector<int> column_, height_;
  std::vector<Ground> ground_;
};

// What a surface's columns say.
struct Votes {
  int columns = 0, last_column = -1;                       // that it is seen in
  int judged = 0, last_judged = -1;                        // of these
  double raised = 0.0, fall = 0.0;                         // sums over the judged
  double rise = -std::numeric_limits<double>::infinity();  // the highest

  double LogRatio() const {
    if (judged == 0 || rise > kSurfaceRise * fall / judged) return 0.0;
    const double share = static_cast<double>(judged) / columns;
    return raised / judged * std::min(kMostWeight, std::sqrt(static_cast<double>(judged))) *
           std::min(1.0, share / kEnoughColumns);
  }
};

// What some columns of a surface say holds for all of it. Not so for `sunk`: what seems far is of
// one depth with all that is far.
std::vector<double> RaisedBySurface(const RoadPlane& road, const Raster& raster,
                                    const std::vector<InverseDepth>& points,
                                    const std::vector<Ground>& grounds,
                                    const std::vector<FootRatios>& ratios) {
  std::vector<bool> is_part(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    is_part[i] = points[i].valid && grounds[i] != Ground::kRoad;
  }
  const std::vector<int> surfaces = FindSurfaces(raster, points, is_part);
  std::vector<Votes> votes(points.size());
  for (int column = 0; column < raster.columns(); ++column) {
    for (int row = raster.rows() - 1; row >= 0; --row) {
      const int i = raster.At(row, column);
      if (i < 0 || surfaces[i] < 0) continue;
      Votes& own = votes[surfaces[i]];
      own.columns += own.last_column != column;
      own.last_column = column;
      own.rise = std::max(own.rise, -road.Fall(points[i].ray));
      if (!ratios[i].judged || own.last_judged == column) continue;
      own.last_judged = column;
      ++own.judged;
      own.raised += ratios[i].raised;
      own.fall += ratios[i].fall;
    }
  }
  std::vector<double> raised(points.size(), 0.0);
  for (size_t i = 0; i < points.size(); ++i) {
    if (surfaces[i] >= 0) raised[i] = votes[surfaces[i]].LogRatio();
  }
  return raised;
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

RoadComparison::RoadComparison(const Pinhole& camera, const RelativePose& pose,
                               const PhotometricSupport& pictures)
    : camera_(camera), back_(Inverse(pose)), reversed_(pictures.Reversed()) {}

std::optional<double> RoadComparison::AgainstRoad(const RoadPlane& road,
                                                  const PointPair& pair) const {
  const cv::Point2f now(static_cast<float>(pair.x2), static_cast<float>(pair.y2));
  const cv::Point2f before(static_cast<float>(pair.x1), static_cast<float>(pair.y1));
  const std::optional<cv::Point2f> as_road = PlaceOfRoadBefore(road, camera_, back_, now);
  if (!as_road) return std::nullopt;
  return reversed_.SignedLogRatio(now, before, *as_road).value_or(0.0);
}

void CompareWithRoad(const RoadPlane& road, const RoadComparison& comparison,
                     const std::vector<PointPair>& pairs, std::vector<InverseDepth>& points) {
  ForEachPoint(points.size(), [&](size_t i) {
    if (!points[i].valid) return;
    const std::optional<double> against_road = comparison.AgainstRoad(road, pairs[i]);
    if (against_road) points[i].against_road = *against_road;
  });
}

std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image,
                                  const FootSearch* feet) {
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
    Column upwards(road, points, places, grounds, feet, by_foot);
    for (int height = 0; height < raster.rows(); ++height) {
      const int i = raster.At(raster.rows() - 1 - height, column);
      if (i >= 0 && points[i].valid) upwards.Add(i, height);
    }
    upwards.Judge();
  }
  const std::vector<double> raised = RaisedBySurface(road, raster, points, grounds, by_foot);
  for (size_t i = 0; i < points.size(); ++i) {
    const int speaker = raster.SpeakerFor(places[i]);
    if (!points[i].valid || !points[speaker].valid || !IsAlike(points[i], points[speaker]))
      continue;
    const FootRatios& foot = by_foot[speaker];
    ratios[i] = std::max({ratios[i], foot.sunk, raised[speaker]});
  }
  return ratios;
}

}  // namespace egosieve::vision
