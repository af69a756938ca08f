#include "tools/evaluation/trajectory_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace egosieve::tools {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180.0;

// Forwards along z at `speed` metres a second, turning about y at `rate` degrees a second, looking
// `aside` degrees from where it goes.
Trajectory Drive(int frames, double speed, double rate, double aside = 0.0) {
  Trajectory trajectory;
  CameraPose body;
  for (int k = 0; k < frames; ++k) {
    CameraPose camera = body;
    camera.rotation = camera.rotation * AngleAxisd(aside * kDegree, Vector3d::UnitY());
    trajectory[k] = camera;
    body.centre += body.rotation * Vector3d(0.0, 0.0, 0.1 * speed);
    body.rotation = body.rotation * AngleAxisd(0.1 * rate * kDegree, Vector3d::UnitY());
  }
  return trajectory;
}

TEST(CompareTrajectories, WorldFrameAndScaleDoNotMatter) {
  const Trajectory truth = Drive(40, 5.0, 10.0);
  Trajectory estimate;
  const Eigen::Matrix3d turn =
      AngleAxisd(1.1, Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (const auto& [frame, pose] : truth) {
    estimate[frame] = {turn * pose.rotation, 0.03 * (turn * pose.centre) + Vector3d(4, 5, 6)};
  }
  const TrajectoryErrors errors = CompareTrajectories(estimate, truth, {});
  EXPECT_EQ(errors.frames, 40);
  EXPECT_LT(*errors.rotation, 1e-9);
  EXPECT_LT(*errors.rotation_neighbours, 1e-9);
  EXPECT_LT(*errors.direction, 1e-9);
}

TEST(CompareTrajectories, AWrongRateOfTurningIsTheRotationError) {
  const TrajectoryErrors errors =
      CompareTrajectories(Drive(40, 5.0, 10.4), Drive(40, 5.0, 10.0), {});
  EXPECT_NEAR(*errors.rotation, 0.4, 1e-9);
  EXPECT_NEAR(*errors.rotation_neighbours, 0.4, 1e-9);
}

// Noise of +-0.05 degrees that alternates is 1 degree a second between neighbours a tenth of a
// second apart, and nothing between frames one second apart: ten frames have the same sign.
TEST(CompareTrajectories, NoiseCountsBetweenNeighboursDriftOverASecond) {
  const Trajectory truth = Drive(40, 5.0, 0.0);
  Trajectory noisy = truth;
  for (auto& [frame, pose] : noisy) {
    pose.rotation =
        pose.rotation * AngleAxisd((frame % 2 == 0 ? 0.05 : -0.05) * kDegree, Vector3d::UnitX());
  }
  const TrajectoryErrors errors = CompareTrajectories(noisy, truth, {});
  EXPECT_NEAR(*errors.rotation, 0.0, 1e-9);
  EXPECT_NEAR(*errors.rotation_neighbours, 1.0, 1e-9);
}

TEST(CompareTrajectories, DirectionIsThatInTheCamerasAxes) {
  EXPECT_NEAR(*CompareTrajectories(Drive(40, 5.0, 0.0, 3.0), Drive(40, 5.0, 0.0), {}).direction,
              3.0, 1e-9);
  // An estimate that stands has no direction.
  EXPECT_NEAR(*CompareTrajectories(Drive(40, 0.0, 0.0), Drive(40, 5.0, 0.0), {}).direction, 90.0,
              1e-9);
}

TEST(CompareTrajectories, SlowTravelIsJudgedOverMoreFramesAndRestNotAtAll) {
  // 0.045 m a frame: 0.1 m are passed after three frames, so the last three have no pair.
  EXPECT_EQ(CompareTrajectories(Drive(40, 0.45, 0.0), Drive(40, 0.45, 0.0), {}).travelling, 37);
  // 0.005 m a frame: 0.05 m in the second that there is.
  const TrajectoryErrors slow = CompareTrajectories(Drive(40, 0.05, 0.0), Drive(40, 0.05, 0.0), {});
  EXPECT_EQ(slow.travelling, 0);
  EXPECT_FALSE(slow.direction.has_value());
}

TEST(CompareTrajectories, OnlyFramesOfBothTakePart) {
  const TrajectoryErrors errors = CompareTrajectories(Drive(5, 5.0, 0.0), Drive(40, 5.0, 0.0), {});
  EXPECT_EQ(errors.frames, 5);
  EXPECT_FALSE(errors.rotation.has_value());
  EXPECT_TRUE(errors.rotation_neighbours.has_value());
}

TEST(ParseTumTrajectory, QuaternionsAreLastAndNormalised) {
  const auto poses = ParseTumTrajectory(
      "# seconds x y z qx qy qz qw\n0.5 1 2 3 0 0 1.4 1.4\n\n0.6 1 2 3 0 0 0 1\n");
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[0].seconds, 0.5);
  EXPECT_EQ((*poses)[0].pose.centre, Vector3d(1, 2, 3));
  // A quarter turn about z takes x to y.
  EXPECT_LT(((*poses)[0].pose.rotation * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_THAT(std::string(ParseTumTrajectory("0 1 2 3\n").status().message()),
              HasSubstr("line 1: 4 numbers"));
  EXPECT_THAT(std::string(ParseTumTrajectory("0 1 2 3 0 0 0 0\n").status().message()),
              HasSubstr("quaternion"));
  EXPECT_FALSE(ParseTumTrajectory("0 1 2 x 0 0 0 1\n").ok());
}

TEST(ParseKittiPoses, RowsAreFrames) {
  const auto poses = ParseKittiPoses("1 0 0 7 0 1 0 8 0 0 1 9\n0 -1 0 1 1 0 0 2 0 0 1 3\n");
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_EQ(poses->at(0).centre, Vector3d(7, 8, 9));
  EXPECT_LT((poses->at(1).rotation * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_FALSE(ParseKittiPoses("0 0 0 7 0 0 0 8 0 0 0 9\n").ok());
}

TEST(ByFrame, PosesFindTheFrameNearestInTime) {
  const Trajectory trajectory =
      ByFrame({{0.011, {}}, {0.149, {}}, {0.9, {}}}, {{4, 0.0}, {5, 0.1}, {7, 0.2}});
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_EQ(trajectory.count(4), 1u);
  EXPECT_EQ(trajectory.count(5), 1u);
}

TEST(ParseCamera, FocalLengthsCompareAtOneWidth) {
  const auto truth = ParseCamera(R"({"focal_pixels": 721.5, "width": 1242, "height": 375})");
  const auto half = ParseCamera(
      R"({"focal_pixels": 396.825, "radial": -0.1, "width": 621, "height": 188,
          "frames_per_second": 15})");
  ASSERT_TRUE(truth.ok() && half.ok());
  EXPECT_NEAR(FocalErrorPercent(*half, *truth), 10.0, 1e-9);
  EXPECT_EQ(half->radial, -0.1);
  EXPECT_EQ(half->frames_per_second, 15.0);
  EXPECT_FALSE(truth->frames_per_second.has_value());
  EXPECT_THAT(std::string(ParseCamera(R"({"width": 5})").status().message()),
              HasSubstr("focal_pixels"));
  EXPECT_FALSE(ParseCamera(R"({"focal_pixels": -1, "width": 5, "height": 5})").ok());
}

TEST(ParseKittiPoses, ReadsTheSharedClips) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA is not set";
  std::ifstream file(std::string(data) + "/kt3dmoseg/Seq013_Clip02/poses.txt");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto poses = ParseKittiPoses(text);
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_GE(poses->size(), 15u);
  EXPECT_LT(*CompareTrajectories(*poses, *poses, {}).direction, 1e-9);
}

}  // namespace
}  // namespace egosieve::tools
