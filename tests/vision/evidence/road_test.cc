#include <cmath>
#include <optional>

#include "gtest/gtest.h"
#include "tests/vision/evidence/road_view.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {
namespace {

TEST(RoadPlane, IsFoundAmongCarsAndHouses) {
  for (const double noise : {0.0, 0.1}) {
    const View view = MakeView(noise);
    const RoadPlane road = FitRoad(InverseDepths(view.camera, view.pose, view.pairs), {}, 1);
    ASSERT_TRUE(road.found);
    // r is in units of 1 / kTravel, so m_y = kTravel / kHeight; the horizon is level.
    EXPECT_NEAR(road.m(1), kTravel / kHeight, 0.02 * kTravel / kHeight);
    EXPECT_NEAR(road.m(2) / road.m(1), 0.0, 0.002);
  }
}

TEST(RoadPlane, FollowsTheLastSlopeOnly) {
  const View view = MakeView(0.1);
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  EXPECT_TRUE(FitRoad(depths, {true, true, 0.0, 0.01}, 1).found);
  // Ten degrees of roll from one frame to the next are another plane.
  EXPECT_FALSE(FitRoad(depths, {true, true, 0.14, 0.0}, 1).found);
}

// Flow creeps where the picture stands still or has nothing to follow.
TEST(RoadPlane, IsNotLookedForWhereNothingMoves) {
  View view = MakeView(0.0);
  for (size_t i = 0; i < view.pairs.size(); ++i) {
    if (view.places[i].y < 240) continue;
    PointPair& pair = view.pairs[i];
    pair.x1 = pair.x2;
    pair.y1 = pair.y2 - 0.4;
  }
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  const RoadPlane road = FitRoad(depths, {}, 1);
  ASSERT_TRUE(road.found);
  EXPECT_NEAR(road.m(1), kTravel / kHeight, 0.02 * kTravel / kHeight);
}

// On three of ten places of the road flow comes half the way.
TEST(RoadPlane, WhatSeemsToLieBelowCountsWhereThePicturesAgree) {
  View view = MakeView(0.0);
  for (size_t i = 0; i < view.pairs.size(); ++i) {
    if (view.what[i] != What::kRoad || i % 10 > 2) continue;
    PointPair& pair = view.pairs[i];
    pair.x1 = 0.5 * (pair.x1 + pair.x2);
    pair.y1 = 0.5 * (pair.y1 + pair.y2);
  }
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  EXPECT_FALSE(FitRoad(depths, {}, 1).found);
  EXPECT_FALSE(FitRoad(depths, {}, 1, [](const RoadPlane&, size_t) { return true; }).found);
  int asked = 0;
  const RoadPlane road = FitRoad(depths, {}, 1, [&](const RoadPlane& plane, size_t point) {
    ++asked;
    EXPECT_LT(depths[point].value, plane.At(depths[point].ray));
    return false;
  });
  ASSERT_TRUE(road.found);
  EXPECT_GT(asked, 30);
  EXPECT_NEAR(road.m(1), kTravel / kHeight, 0.03 * kTravel / kHeight);
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
    return point.views_road_log_ratio.value_or(0.0);
  });
}

double MeanProbability(const View& view, const EvidenceResult& result, What what) {
  return MeanOf(view, result, what, [](const PointEvidence& point) { return point.probability; });
}

TEST(RoadAhead, APairAheadTellsCarsByTheGround) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_FALSE(result.road);  // of no pair behind
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 4.0);
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kOncoming), 4.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kRoad), 0.1);
  // It is a part of the probability, of cars that move along their epipolar lines.
  EXPECT_GT(MeanProbability(view, result, What::kOncoming), 0.6);
  EvidenceAccumulator without;
  const EvidenceResult plain = *without.Add(FrameBeforeRoadView(view, 0.0));
  EXPECT_LT(MeanProbability(view, plain, What::kOncoming), 0.3);
}

// A plane that only the pair ahead shows is not believed.
TEST(RoadAhead, APairAheadNeedsAGroundThatIsKnown) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, 0.0));
  for (const PointEvidence& point : result.points) EXPECT_FALSE(point.views_road_log_ratio);
}

// Where the camera moves to is its horizon only if it keeps its direction of travel.
TEST(RoadAhead, AHandHeldCameraHasNoKnownGround) {
  const View view = MakeView(0.05);
  EvidenceFrame frame = FrameBeforeRoadView(view, kTravel / kHeight);
  frame.views[0].motion.travel.reset();
  EvidenceAccumulator accumulator;
  const EvidenceResult result = *accumulator.Add(frame);
  for (const PointEvidence& point : result.points) EXPECT_FALSE(point.views_road_log_ratio);
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
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 3.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
}

// When a plane that a pair of pictures shows counts as the road.

// The view's picture as frame `index`, `world` the motion from the picture before it. tilt: the
// camera is turned by as much, about the line of sight, in both pictures; radians.
EvidenceFrame FrameOf(const View& view, int index, std::optional<Eigen::Vector3d> travel,
                      double tilt = 0.0) {
  EvidenceFrame frame{.index = index, .size = kImage, .camera = view.camera};
  const TwoViewMotion motion{.found = true,
                             .translation = -Eigen::Vector3d::UnitZ(),
                             .mean_parallax = 0.05,
                             .noise = 0.1 / view.camera.focal_pixels,
                             .static_share = 0.9,
                             .moving_scale = 0.02,
                             .noise_pixels = 0.1,
                             .parallax_pixels = 3.0,
                             .travel = travel};
  frame.world = motion;
  const auto turned = [&](double x, double y) {
    const double dx = x - view.camera.centre_x, dy = y - view.camera.centre_y;
    return cv::Point2f(
        static_cast<float>(view.camera.centre_x + std::cos(tilt) * dx - std::sin(tilt) * dy),
        static_cast<float>(view.camera.centre_y + std::sin(tilt) * dx + std::cos(tilt) * dy));
  };
  for (const PointPair& pair : view.pairs) {
    EvidencePoint& point = frame.points.emplace_back();
    point.now = turned(pair.x2, pair.y2);
    point.before = turned(pair.x1, pair.y1);
    point.estimates = true;
  }
  return frame;
}

bool SaysOfTheRoad(const EvidenceResult& result) {
  for (const PointEvidence& point : result.points) {
    if (point.present[static_cast<int>(EvidenceTerm::kRoad)]) return true;
  }
  return false;
}

TEST(RoadConfirmation, AnotherPictureConfirmsThePlane) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 1, std::nullopt))));
  EXPECT_TRUE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 2, std::nullopt))));
  EXPECT_TRUE(accumulator.state().road.known);
}

// A camera that stands or turns on the spot measures no depths.
TEST(RoadConfirmation, ThereIsNoRoadWithoutParallax) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  for (int t = 1; t <= 3; ++t) {
    EvidenceFrame frame = FrameOf(view, t, std::nullopt);
    frame.world->parallax_pixels = 0.0;
    EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(frame)));
    EXPECT_FALSE(accumulator.state().road.proposed);
  }
}

TEST(RoadConfirmation, AnotherPlaneDoesNot) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  for (int t = 1; t <= 4; ++t) {
    // Six degrees of roll to and fro.
    const double tilt = t % 2 == 0 ? 0.05 : -0.05;
    EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt, tilt)))) << t;
    EXPECT_TRUE(accumulator.state().road.proposed);
    EXPECT_FALSE(accumulator.state().road.known);
  }
}

TEST(RoadConfirmation, ASlopeIsRememberedForFiveFramesThatDoNotShowIt) {
  const View view = MakeView(0.05);
  const double steep = 0.3;  // radians of roll, more than a camera on a car has
  for (const int unseen : {5, 6}) {
    EvidenceAccumulator accumulator;
    int t = 1;
    for (; t <= 2; ++t) ASSERT_TRUE(accumulator.Add(FrameOf(view, t, std::nullopt)).ok());
    for (; t <= 2 + unseen; ++t) {
      EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt, steep))));
    }
    EXPECT_EQ(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt))), unseen == 5);
  }
}

TEST(RoadConfirmation, TheDirectionOfTravelConfirmsALevelPlaneBelowIt) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator;
  EXPECT_TRUE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 1, -Eigen::Vector3d::UnitZ()))));
  // Travel three degrees below the plane's horizon.
  EvidenceAccumulator other;
  const Eigen::Vector3d below = Eigen::Vector3d(0.0, -0.05, -1.0).normalized();
  EXPECT_FALSE(SaysOfTheRoad(*other.Add(FrameOf(view, 1, below))));
}

}  // namespace
}  // namespace egosieve::vision
