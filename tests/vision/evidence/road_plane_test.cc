#include "vision/evidence/road_plane.h"

#include <gtest/gtest.h>

#include "tests/vision/evidence/road_view.h"

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

}  // namespace
}  // namespace egosieve::vision
