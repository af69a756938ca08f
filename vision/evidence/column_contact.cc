#include "vision/evidence/column_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kOnRoad = 0.15;  // greatest difference from the road, of its inverse depth
constexpr double kSeenOnRoad = 1.0, kSeenOffRoad = 3.0;  // bounds of against_road
constexpr int kRoadBelow = 2;    // fewest points of road below a ground contact
constexpr int kMostMissed = 2;   // cells without a place, within a stretch
constexpr int kMostBetween = 4;  // cells between the road and the stretch
constexpr int kFewestAlike = 2;  // places of a stretch that are not road
// Least size of a stretch; a smaller one may be motion that smooth flow carries onto the road.
constexpr size_t kEnoughPlaces = 3;
constexpr double kEnoughRise = 0.3;  // of the camera's height
constexpr double kSureRoad = 5.0;    // least inverse depth of certain road, in deviations
constexpr double kMostRise = 2.5;    // above the camera, in camera heights; no vehicle is taller
constexpr double kCarRise = 0.3, kVanRise = 0.5;  // the same, of their roofs
constexpr double kLeastFall = 0.02;      // of A_y below the horizon: 70 m for a camera on a car
constexpr double kHorizonError = 0.003;  // of A_y
constexpr double kMostLogRatio = 6.0;
// The ground around an object: cells to either side, the fewest places of road, the least
// unevenness with that many places, the unevenness with fewer, and the bounds of the ratio of its
// inverse depth to the plane's.
constexpr int kCellsAround = 12;
constexpr size_t kFewestAround = 8;
constexpr double kLeastUnevenness = 0.07, kUnseenUnevenness = 0.12;
constexpr double kLeastColumnShare = 0.8, kMostColumnShare = 1.1, kLeastOfDepth = 0.8;

// A column of the image from the bottom upwards. Finds the objects above the road, and compares
// their depth with the road's at their ground contact.
class Column {
 public:
  Column(const ColumnView& view, std::vector<PointContact>& contacts)
      : view_(view), contacts_(contacts) {}

  // Adds the next point upwards, in the raster's cell `height`, counted from below.
  void Add(int point, int height) {
    column_.push_back(point);
    ground_.push_back(view_.grounds[point]);
    height_.push_back(height);
  }

  void Judge() {
    int road_below = 0;
    size_t road_top = 0;
    for (size_t k = 0; k < column_.size();) {
      if (ground_[k] == Ground::kRoad) {
        ++road_below;
        road_top = k++;
      } else if (road_below < kRoadBelow || Cells(road_top, k) > kMostBetween) {
        road_below = 0;
        ++k;
      } else if (ground_[k] == Ground::kUnclear) {
        ++k;
      } else {
        k = JudgeAbove(road_top, k);
        road_below = 0;
      }
    }
  }

 private:
  const InverseDepth& At(size_t k) const { return view_.points[column_[k]]; }
  double Rise(size_t k) const { return -view_.road.Fall(At(k).ray); }
  // Distance in cells; some of them may have no place.
  int Cells(size_t lower, size_t upper) const { return height_[upper] - height_[lower]; }
  // Of a point of the view.
  bool IsSureRoad(int point) const {
    const InverseDepth& depth = view_.points[point];
    return view_.grounds[point] == Ground::kRoad &&
           view_.road.At(depth.ray) > kSureRoad * depth.deviation;
  }

  // Medians of r and of its deviation over places in the column.
  InverseDepth MiddleOf(const std::vector<size_t>& stretch) const {
    std::vector<double> values, deviations;
    for (const size_t k : stretch) {
      values.push_back(At(k).value);
      deviations.push_back(At(k).deviation);
    }
    InverseDepth middle;
    middle.value = MedianInPlace(values);
    middle.deviation = MedianInPlace(deviations);
    return middle;
  }

  // Indices in the column, from `first` upwards, of points that are alike the mean of the stretch.
  // Neighbours are not compared with each other: flow is smooth, so a chain of similar neighbours
  // can lead from one object to the next.
  std::vector<size_t> StretchFrom(size_t first) const {
    std::vector<size_t> stretch = {first};
    InverseDepth mean = At(first);
    for (size_t k = first + 1; k < column_.size() && Cells(stretch.back(), k) <= kMostMissed + 1;
         ++k) {
      if (k > first + 1 && IsSureRoad(column_[k]) && IsSureRoad(column_[k - 1])) break;
      // Near the horizon every point fits the road; true road soon differs from the first point.
      if (!IsAlike(mean, At(k))) continue;
      if (ground_[k] == Ground::kRoad && !IsAlike(At(first), At(k))) continue;
      stretch.push_back(k);
      const double share = 1.0 / static_cast<double>(stretch.size());
      mean.value += share * (At(k).value - mean.value);
      mean.deviation += share * (At(k).deviation - mean.deviation);
    }
    return stretch;
  }

  // The first stretch above `road_top` that is large enough; if there is none, the longest.
  // road_top: the last point of road; off: the first point above it that is not road.
  std::vector<size_t> StretchAbove(size_t road_top, size_t off) const {
    const double least_rise = kEnoughRise * view_.road.Fall(At(road_top).ray);
    std::vector<size_t> longest;
    for (size_t k = road_top + 1; k < column_.size() && Cells(off, k) <= kMostBetween; ++k) {
      if (ground_[k] == Ground::kRoad) break;
      std::vector<size_t> stretch = StretchFrom(k);
      const bool is_enough = stretch.size() >= kEnoughPlaces &&
                             Rise(stretch.back()) - Rise(stretch.front()) >= least_rise;
      if (is_enough) return stretch;
      if (stretch.size() > longest.size()) longest = std::move(stretch);
    }
    return longest;
  }

  // Judges the stretch above `road_top`. Returns the index in the column after it.
  size_t JudgeAbove(size_t road_top, size_t off) {
    std::vector<size_t> stretch = StretchAbove(road_top, off);
    const auto seen = std::count_if(stretch.begin(), stretch.end(),
                                    [&](size_t k) { return ground_[k] == Ground::kOff; });
    if (seen < kFewestAlike) return off + 1;
    const size_t behind = stretch.back() + 1;
    // Blank background (a wall, the sky) may continue the stretch; it is not part of the object.
    while (!stretch.empty() && !At(stretch.back()).is_textured) stretch.pop_back();
    if (stretch.empty()) return behind;
    const double fall = view_.road.Fall(At(road_top).ray);
    const bool is_tall = Rise(stretch.back()) > kMostRise * fall;
    // An object that seems far is alike to distant, taller objects behind it.
    while (is_tall && !stretch.empty() && Rise(stretch.back()) > kCarRise * fall) {
      stretch.pop_back();
    }
    if (stretch.empty()) return behind;
    const InverseDepth middle = MiddleOf(stretch);
    PointContact contact;
    contact.judged = view_.road.Fall(At(stretch.front()).ray) > kLeastFall;
    if (contact.judged) {
      contact.ratios = Contact(middle, stretch[stretch.size() / 2]);
      if (is_tall) contact.ratios.too_near = 0.0;
    }
    for (size_t k = road_top + 1; k < stretch.front(); ++k) {
      const double own = At(k).value;
      if (std::abs(own - middle.value) < std::abs(own - view_.road.At(At(k).ray)))
        stretch.push_back(k);
    }
    for (const size_t k : stretch) {
      contacts_[column_[k]] = contact;
      if (Rise(k) > kVanRise * fall) contacts_[column_[k]].ratios.too_far = 0.0;
    }
    return behind;
  }

  // Sets ground_share and unevenness from the road beside and below `place`, where the object may
  // touch the ground.
  void SetGroundAround(cv::Point2f place, ContactDepths& depths) const {
    std::vector<double> shares;
    const auto [top, middle] = view_.raster.CellAt(place);
    const int first = std::max(0, middle - kCellsAround);
    const int last = std::min(view_.raster.columns() - 1, middle + kCellsAround);
    const double highest = std::max(kLeastOfDepth * depths.inverse_depth, 0.0);
    for (int row = top; row < view_.raster.rows(); ++row) {
      for (int column = first; column <= last; ++column) {
        const int i = view_.raster.At(row, column);
        if (i < 0 || !IsSureRoad(i) || !view_.points[i].is_textured) continue;
        const double at = view_.road.At(view_.points[i].ray);
        if (at > highest && at < depths.lowest) shares.push_back(view_.points[i].value / at);
      }
    }
    if (shares.size() < kFewestAround) {
      depths.unevenness = kUnseenUnevenness;
      return;
    }
    const double share = MedianInPlace(shares);
    for (double& each : shares) each = std::abs(each - share);
    depths.ground_share = std::clamp(share, kLeastColumnShare, kMostColumnShare);
    depths.unevenness = RobustScale(std::move(shares), kLeastUnevenness);
  }

  // Without pictures: rows at the places of the column, from its index `top` downwards.
  std::vector<ContactRow> PlacesBelow(size_t top, const ContactDepths& depths) const {
    std::vector<ContactRow> rows;
    for (size_t k = top + 1; k-- > 0;) {
      const InverseDepth& point = At(k);
      ContactRow row;
      row.ground = view_.road.At(point.ray);
      if (row.ground > depths.lowest) break;
      const double deviation = std::hypot(point.deviation, depths.unevenness * row.ground);
      const double from_object = (point.value - depths.inverse_depth) / deviation;
      const double from_ground =
          std::min(std::abs(point.value - row.ground),
                   std::abs(point.value - depths.ground_share * row.ground)) /
          deviation;
      row.gain = std::isfinite(point.against_road)
                     ? point.against_road
                     : 0.5 * (from_ground * from_ground - from_object * from_object);
      rows.push_back(row);
    }
    return rows;
  }

  ContactRatios Contact(const InverseDepth& middle, size_t top) const {
    const cv::Point2f place = view_.places[column_[top]];
    ContactDepths depths;
    depths.inverse_depth = middle.value;
    depths.deviation = std::hypot(middle.deviation, kHorizonError * view_.road.m(1));
    depths.lowest = LowestGround(view_.road.At(At(top).ray), middle.value);
    SetGroundAround(place, depths);
    const std::vector<ContactRow> rows = view_.pictures != nullptr
                                             ? view_.pictures->RowsBelow(place, depths)
                                             : PlacesBelow(top, depths);
    ContactRatios ratios = RatiosOfContact(rows, depths);
    ratios.too_far = std::min(kMostLogRatio, ratios.too_far);
    ratios.too_near = std::min(kMostLogRatio, ratios.too_near);
    return ratios;
  }

  const ColumnView& view_;
  std::vector<PointContact>& contacts_;
  std::vector<int> column_, height_;
  std::vector<Ground> ground_;
};

}  // namespace

bool IsAlike(const InverseDepth& a, const InverseDepth& b) {
  return std::abs(a.value - b.value) < 2.5 * std::hypot(a.deviation, b.deviation) +
                                           0.1 * std::max(std::abs(a.value), std::abs(b.value));
}

Ground GroundOf(const RoadPlane& road, const InverseDepth& point) {
  if (point.against_road < -kSeenOnRoad) return Ground::kRoad;
  const double at = road.At(point.ray);
  const bool fits = at > 0.0 && std::abs(point.value - at) < 2.0 * point.deviation + kOnRoad * at;
  if (!(point.against_road < kSeenOffRoad)) {
    return fits && std::isinf(point.against_road) ? Ground::kRoad : Ground::kOff;
  }
  return fits ? Ground::kRoad : Ground::kUnclear;
}

std::vector<PointContact> ContactsByColumn(const ColumnView& view) {
  std::vector<PointContact> contacts(view.points.size());
  for (int column = 0; column < view.raster.columns(); ++column) {
    Column upwards(view, contacts);
    for (int height = 0; height < view.raster.rows(); ++height) {
      const int i = view.raster.At(view.raster.rows() - 1 - height, column);
      if (i >= 0 && view.points[i].valid) upwards.Add(i, height);
    }
    upwards.Judge();
  }
  return contacts;
}

}  // namespace egosieve::vision
