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
  EXPECT_TRUE(FitRoad(depths, {true, 0.0, 0.01}, 1).found);
  // Ten degrees of roll from one frame to the next are another plane.
  EXPECT_FALSE(FitRoad(depths, {true, 0.14, 0.0}, 1).found);
}

}  // namespace
}  // namespace egosieve::vision
