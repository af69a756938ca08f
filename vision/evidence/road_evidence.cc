#include "vision/evidence/road_evidence.h"

#include "vision/evidence/road_contact.h"

namespace egosieve::vision {
namespace {

constexpr double kMostDoubt = 1.5;  // log-likelihood ratio of a place that stands still

cv::Point2f Now(const PointPair& pair) {
  return {static_cast<float>(pair.x2), static_cast<float>(pair.y2)};
}

PointPair PairOf(const GuidedPlace& place) {
  return {place.before.x, place.before.y, place.now.x, place.now.y};
}

}  // namespace

RoadEvidence MeasureRoad(const RoadView& view, const RoadSlope& last, uint64_t seed) {
  RoadEvidence result;
  std::vector<InverseDepth> depths = InverseDepths(view.camera, view.pose, view.pairs);
  for (size_t i = 0; i < depths.size(); ++i) depths[i].is_textured = view.is_textured[i];
  result.road = FitRoad(depths, last, seed);
  if (!result.road.found) return result;

  std::vector<PointPair> pairs = view.pairs;
  std::vector<GuidedPlace> guided;
  if (view.pictures != nullptr) {
    guided = GuidedMatcher(view.before, view.now, view.camera, view.pose, result.road,
                           view.pictures->noise_levels())
                 .Match(view.unfollowed);
    for (const GuidedPlace& place : guided) pairs.push_back(PairOf(place));
    const std::vector<InverseDepth> guided_depths = InverseDepths(
        view.camera, view.pose, {pairs.begin() + std::ptrdiff_t(view.pairs.size()), pairs.end()});
    for (size_t i = 0; i < guided.size(); ++i) {
      depths.push_back(guided_depths[i]);
      depths.back().valid &= guided[i].has_depth;
    }
    CompareWithRoad(result.road, view.camera, view.pose, *view.pictures, pairs, depths);
  }
  std::vector<cv::Point2f> places;
  for (const PointPair& pair : pairs) places.push_back(Now(pair));
  std::vector<double> ratios = RoadLogRatios(result.road, depths, places, view.size);
  for (size_t i = 0; i < guided.size(); ++i) {
    if (ratios[view.pairs.size() + i] < kMostDoubt) result.standing.push_back(guided[i]);
  }
  ratios.resize(view.pairs.size());
  result.log_ratios = std::move(ratios);
  return result;
}

}  // namespace egosieve::vision
