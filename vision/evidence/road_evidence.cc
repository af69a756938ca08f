#include "vision/evidence/road_evidence.h"

#include <optional>

#include "vision/evidence/road_contact.h"

namespace egosieve::vision {
namespace {

constexpr double kMostDoubt = 1.5;  // bound of the log-likelihood ratio of a static place
constexpr double kSeenOff = 3.0;    // least ratio of grey levels for a place off the plane

void Append(const std::vector<GuidedPlace>& guided, const RoadView& view,
            std::vector<PointPair>& pairs, std::vector<InverseDepth>& depths) {
  std::vector<PointPair> added;
  for (const GuidedPlace& place : guided) {
    added.push_back({place.before.x, place.before.y, place.now.x, place.now.y});
  }
  const std::vector<InverseDepth> added_depths = InverseDepths(view.camera, view.pose, added);
  pairs.insert(pairs.end(), added.begin(), added.end());
  depths.insert(depths.end(), added_depths.begin(), added_depths.end());
}

}  // namespace

RoadEvidence MeasureRoad(const RoadView& view, const RoadSlope& last, uint64_t seed) {
  RoadEvidence result;
  std::vector<PointPair> pairs = view.pairs;
  std::vector<InverseDepth> depths = InverseDepths(view.camera, view.pose, pairs);
  for (size_t i = 0; i < depths.size(); ++i) depths[i].is_textured = view.is_textured[i];
  std::optional<RoadComparison> comparison;
  IsSeenOffPlane is_seen_off;
  if (view.pictures != nullptr) {
    comparison.emplace(view.camera, view.pose, *view.pictures);
    is_seen_off = [&](const RoadPlane& plane, size_t point) {
      return comparison->AgainstRoad(plane, pairs[point]).value_or(kSeenOff) >= kSeenOff;
    };
  }
  result.road = FitRoad(depths, last, seed, is_seen_off);
  if (!result.road.found && view.plane) result.road = {true, *view.plane};
  if (!result.road.found) return result;

  std::vector<GuidedPlace> guided;
  if (view.pictures != nullptr) {
    guided = MatchRoad(result.road, view.camera, view.pose, view.before, view.now,
                       view.pictures->noise_levels(), view.unfollowed);
    Append(guided, view, pairs, depths);
    CompareWithRoad(result.road, *comparison, pairs, depths);
  }
  std::vector<cv::Point2f> places;
  for (const PointPair& pair : pairs) {
    places.emplace_back(static_cast<float>(pair.x2), static_cast<float>(pair.y2));
  }
  std::optional<ContactPictures> contact;
  if (view.pictures != nullptr) {
    contact.emplace(result.road, view.camera, view.pose, view.before, view.now,
                    view.pictures->noise_levels());
  }
  result.log_ratios =
      RoadLogRatios(result.road, depths, places, view.size, contact ? &*contact : nullptr);
  for (size_t i = 0; i < guided.size(); ++i) {
    if (result.log_ratios[view.pairs.size() + i] < kMostDoubt) result.standing.push_back(guided[i]);
  }
  result.log_ratios.resize(view.pairs.size());
  return result;
}

}  // namespace egosieve::vision
