#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/evidence/road_view.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {
namespace {

TEST(RoadPlane, IsFoundAmongCarsAndHouses) {
  for (const double noise : {0.0, 0.1}) {
    const View view = MakeView(noise);
    // The drive tells the speed and the pitch by one deviation wrong.
    const Eigen::Vector3d level = 1.15 * kLevel + 0.01 * kLevel(1) * Eigen::Vector3d::UnitZ();
    const RoadPlane road = FitRoad(InverseDepths(view.camera, view.pose, view.pairs), level);
    EXPECT_NEAR(road.m(1), kLevel(1), 0.02 * kLevel(1));
    EXPECT_NEAR(road.m(2) / road.m(1), 0.0, 0.002);
  }
}

// Places of the view turned about the line of sight.
TEST(RoadPlane, FollowsTheRollOfTheCamera) {
  const View view = MakeView(0.1);
  const double roll = 0.03;
  const Eigen::Rotation2Dd turn(roll);
  const Eigen::Vector2d centre(view.camera.centre_x, view.camera.centre_y);
  std::vector<PointPair> turned;
  for (const PointPair& pair : view.pairs) {
    const Eigen::Vector2d a = centre + turn * (Eigen::Vector2d(pair.x1, pair.y1) - centre);
    const Eigen::Vector2d b = centre + turn * (Eigen::Vector2d(pair.x2, pair.y2) - centre);
    turned.push_back({a(0), a(1), b(0), b(1)});
  }
  const RoadPlane road = FitRoad(InverseDepths(view.camera, view.pose, turned), kLevel);
  EXPECT_NEAR(road.m(0) / road.m(1), -std::tan(roll), 0.1 * roll);
}

// Flow creeps where the picture stands still or has nothing to follow.
TEST(RoadPlane, StaysLevelWhereNothingMoves) {
  View view = MakeView(0.0);
  for (PointPair& pair : view.pairs) {
    pair.x1 = pair.x2;
    pair.y1 = pair.y2 - 0.4;
  }
  // By as much as the road would at a slow walk, and as at the speed of the drive.
  for (const double share : {0.02, 1.0}) {
    const Eigen::Vector3d level = share * kLevel;
    const RoadPlane road = FitRoad(InverseDepths(view.camera, view.pose, view.pairs), level);
    EXPECT_TRUE(road.m.isApprox(level, 1e-12)) << share;
  }
}

// What the road says by a pair of pictures ahead.

// road_view.h has where the places were in a picture before; here that picture is one ahead.
EvidenceFrame FrameBeforeRoadView(const View& view, double ground_heights) {
  EvidenceFrame frame{.index = 1, .size = kImage, .camera = view.camera};
  EvidenceView& ahead = frame.views.emplace_back();
  ahead.pictures = 5;
  ahead.motion.found = true;
  ahead.motion.translation = Eigen::Vector3d::UnitZ();
  ahead.motion.mean_parallax = 0.05;
  ahead.motion.noise_pixels = 0.1;
  ahead.motion.noise = 0.1 / view.camera.focal_pixels;
  ahead.motion.static_share = 0.9;
  ahead.motion.moving_scale = 0.02;
  ahead.motion.parallax_pixels = 3.0;
  ahead.motion.ground_heights = ground_heights;
  ahead.motion.travel = Eigen::Vector3d::UnitZ();
  for (size_t i = 0; i < view.places.size(); ++i) {
    EvidencePoint& point = frame.points.emplace_back();
    point.now = view.places[i];
    ahead.places.emplace_back(static_cast<float>(view.pairs[i].x1),
                              static_cast<float>(view.pairs[i].y1));
  }
  return frame;
}

// Over the points of one kind.
template <typename Value>
double MeanOf(const View& view, const EvidenceResult& result, What what, const Value& value) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < result.points.size(); ++i) {
    if (view.what[i] != what) continue;
    ++count;
    sum += value(result.points[i]);
  }
  return sum / count;
}

double MeanRoadRatioAhead(const View& view, const EvidenceResult& result, What what) {
  return MeanOf(view, result, what, [](const PointEvidence& point) {
    return point.of_views[static_cast<int>(EvidenceTerm::kRoad)].value_or(0.0);
  });
}

double MeanProbability(const View& view, const EvidenceResult& result, What what) {
  return MeanOf(view, result, what, [](const PointEvidence& point) { return point.probability; });
}

TEST(RoadAhead, APairAheadTellsCarsByTheGround) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 4.0);
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kOncoming), 4.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kRoad), 0.1);
  // It is a part of the probability, of cars that move along their epipolar lines.
  EXPECT_GT(MeanProbability(view, result, What::kOncoming), 0.6);
  EvidenceAccumulator without;
  const EvidenceResult plain = without.Add(FrameBeforeRoadView(view, 0.0));
  EXPECT_LT(MeanProbability(view, plain, What::kOncoming), 0.3);
}

TEST(RoadAhead, APairAheadNeedsAGroundThatIsKnown) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(FrameBeforeRoadView(view, 0.0));
  for (const PointEvidence& point : result.points)
    EXPECT_FALSE(point.of_views[static_cast<int>(EvidenceTerm::kRoad)]);
}

// Where the camera moves to is its horizon only if it keeps its direction of travel.
TEST(RoadAhead, AHandHeldCameraHasNoKnownGround) {
  const View view = MakeView(0.05);
  EvidenceFrame frame = FrameBeforeRoadView(view, kTravel / kHeight);
  frame.views[0].motion.travel.reset();
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(frame);
  for (const PointEvidence& point : result.points)
    EXPECT_FALSE(point.of_views[static_cast<int>(EvidenceTerm::kRoad)]);
}

// Flow stays at nought on a blank road, which shows no plane then.
TEST(RoadAhead, AKnownGroundReplacesARoadThatFlowDoesNotShow) {
  View view = MakeView(0.05);
  for (size_t i = 0; i < view.places.size(); ++i) {
    if (view.what[i] != What::kRoad) continue;
    view.pairs[i].x1 = view.places[i].x;
    view.pairs[i].y1 = view.places[i].y;
  }
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 3.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
}

// What the road says by the pair behind.

EvidenceFrame FrameAfterRoadView(const View& view) {
  EvidenceFrame frame{.index = 1, .size = kImage, .camera = view.camera};
  TwoViewMotion& world = frame.world.emplace();
  world.found = true;
  world.translation = -Eigen::Vector3d::UnitZ();
  world.mean_parallax = 0.05;
  world.noise = 0.1 / view.camera.focal_pixels;
  world.static_share = 0.9;
  world.moving_scale = 0.02;
  world.noise_pixels = 0.1;
  world.parallax_pixels = 3.0;
  world.ground_heights = kTravel / kHeight;
  world.travel = -Eigen::Vector3d::UnitZ();
  for (const PointPair& pair : view.pairs) {
    EvidencePoint& point = frame.points.emplace_back();
    point.now = {static_cast<float>(pair.x2), static_cast<float>(pair.y2)};
    point.before = {static_cast<float>(pair.x1), static_cast<float>(pair.y1)};
    point.estimates = true;
  }
  return frame;
}

bool SaysOfTheRoad(const EvidenceResult& result) {
  for (const PointEvidence& point : result.points) {
    if (point.of_pair[static_cast<int>(EvidenceTerm::kRoad)]) return true;
  }
  return false;
}

TEST(RoadBehind, ThePairTellsCarsByTheGround) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(FrameAfterRoadView(view));
  EXPECT_TRUE(SaysOfTheRoad(result));
  EXPECT_GT(MeanProbability(view, result, What::kOncoming), 0.6);
}

TEST(RoadBehind, AHandHeldCameraHasNoKnownGround) {
  const View view = MakeView(0.05);
  EvidenceFrame frame = FrameAfterRoadView(view);
  frame.world->travel.reset();
  EvidenceAccumulator accumulator;
  EXPECT_FALSE(SaysOfTheRoad(accumulator.Add(frame)));
}

// A camera that stands or turns on the spot measures no depths.
TEST(RoadBehind, ThereIsNoRoadWithoutParallax) {
  const View view = MakeView(0.05);
  EvidenceFrame frame = FrameAfterRoadView(view);
  frame.world->parallax_pixels = 0.0;
  EvidenceAccumulator accumulator;
  EXPECT_FALSE(SaysOfTheRoad(accumulator.Add(frame)));
}

}  // namespace
}  // namespace egosieve::vision
