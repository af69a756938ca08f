#include "vision/matching/scene_agreement.h"

#include <algorithm>

#include "vision/image/cell_grid.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kFewestPoints = 12;
constexpr int kFewestAreas = 6;
constexpr double kFlowHolds = 0.25, kFeaturesHold = 0.08, kFeaturesOfThePictureHold = 0.03;
constexpr double kLeastShare = 0.35;

bool Holds(int64_t agreeing, int64_t all, double share) {
  return all >= kFewestPoints && static_cast<double>(agreeing) >= share * static_cast<double>(all);
}

}  // namespace

void SceneAgreement::Add(cv::Point2f place, bool agrees, AreaVotes& areas) const {
  constexpr CellGrid kCells{.columns = kColumns, .rows = kRows};
  Votes& votes = areas[kCells.IndexAt(place.x / static_cast<float>(size_.width) * kColumns,
                                      place.y / static_cast<float>(size_.height) * kRows)];
  ++votes.all;
  votes.agreeing += agrees ? 1 : 0;
}

SceneAgreement::Areas SceneAgreement::CountAreas() const {
  Areas areas;
  Votes flow, features;
  for (size_t i = 0; i < flow_.size(); ++i) {
    areas.judged += std::max(flow_[i].all, features_[i].all) >= kFewestPoints;
    areas.holding += Holds(flow_[i].agreeing, flow_[i].all, kFlowHolds) ||
                     Holds(features_[i].agreeing, features_[i].all, kFeaturesHold);
    flow.all += flow_[i].all;
    flow.agreeing += flow_[i].agreeing;
    features.all += features_[i].all;
    features.agreeing += features_[i].agreeing;
  }
  if (areas.judged >= kFewestAreas) return areas;
  const bool holds = Holds(flow.agreeing, flow.all, kFlowHolds) ||
                     Holds(features.agreeing, features.all, kFeaturesOfThePictureHold);
  return {1, holds ? 1 : 0};
}

bool SceneAgreement::IsOneScene() const {
  const Areas areas = CountAreas();
  return areas.holding >= kLeastShare * areas.judged;
}

}  // namespace egosieve::vision
