#include "vision/synthetic/drive.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::vision {
namespace {

TEST(PathTest, QuarterTurnEndsBesideItsCentre) {
  Path path({1.0, 2.0}, 0.0);
  path.Straight(10.0).Turn(5.0, M_PI / 2).Straight(3.0);
  const double arc = 5.0 * M_PI / 2;
  const PathPoint end = path.At(10.0 + arc + 3.0);
  EXPECT_NEAR(end.position.x(), 1.0 + 10.0 + 5.0, 1e-12);
  EXPECT_NEAR(end.position.y(), 2.0 + 5.0 + 3.0, 1e-12);
  EXPECT_NEAR(end.heading_radians, M_PI / 2, 1e-12);
}

TEST(PathTest, IsAUnitSpeedCurve) {
  Path path({0.0, 0.0}, 0.3);
  path.Straight(4.0).Turn(6.0, -1.1).Turn(3.0, 2.0).Straight(2.0);
  constexpr double kStep = 1e-5;
  for (double s = -2.0; s < 25.0; s += 0.37) {
    const Eigen::Vector2d tangent =
        (path.At(s + kStep).position - path.At(s - kStep).position) / (2 * kStep);
    const double heading = path.At(s).heading_radians;
    // Central differences: error of order step^2 curvature^2, and step curvature at joints.
    EXPECT_NEAR(tangent.x(), std::cos(heading), 1e-5) << s;
    EXPECT_NEAR(tangent.y(), std::sin(heading), 1e-5) << s;
  }
}

TEST(PathTest, ShiftMovesToTheLeft) {
  Path path({0.0, 0.0}, M_PI);  // westwards: left is south
  path.Straight(100.0).Shift(10.0, 30.0, 3.0);
  EXPECT_NEAR(path.At(5.0).position.y(), 0.0, 1e-12);
  EXPECT_NEAR(path.At(20.0).position.y(), -1.5, 1e-12);
  EXPECT_NEAR(path.At(40.0).position.y(), -3.0, 1e-12);
  EXPECT_GT(path.At(20.0).heading_radians, M_PI);
}

TEST(DriveTest, TravelledIsTheIntegralOfSpeed) {
  const Drive drive(Path({0.0, 0.0}, 0.0), 7.0,
                    {{-1.0, 4.0}, {2.0, 10.0}, {3.0, 0.0}, {5.0, 0.0}, {6.0, 2.0}});
  EXPECT_EQ(drive.Travelled(0.0), 0.0);
  EXPECT_NEAR(drive.Travelled(2.0), 0.5 * 2.0 * (6.0 + 10.0), 1e-12);
  EXPECT_NEAR(drive.Travelled(4.0), 16.0 + 5.0, 1e-12);
  EXPECT_NEAR(drive.Travelled(8.0), 16.0 + 5.0 + 1.0 + 4.0, 1e-12);
  EXPECT_NEAR(drive.Travelled(-3.0), -(0.5 * (4.0 + 6.0) + 2.0 * 4.0), 1e-12);
  EXPECT_EQ(drive.Speed(4.0), 0.0);
  EXPECT_EQ(drive.At(4.2).pose.position, drive.At(4.8).pose.position);
  EXPECT_NEAR(drive.At(2.0).pose.position.x(), 7.0 + 16.0, 1e-12);
  EXPECT_NEAR(drive.At(1.0).velocity.x(), 8.0, 1e-6);
}

TEST(DriveTest, WithoutKeysItStands) {
  const Drive drive(Path({3.0, 4.0}, 1.0), 0.0, {});
  EXPECT_EQ(drive.At(9.0).pose.position, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(drive.At(9.0).velocity.norm(), 0.0);
}

}  // namespace
}  // namespace egosieve::vision
