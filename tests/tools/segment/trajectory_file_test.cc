#include "tools/segment/trajectory_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tools/evaluation/trajectory_errors.h"

namespace egosieve::tools {
namespace {

TEST(TrajectoryFile, PosesAreReadAgainAsTheyAre) {
  std::vector<FrameLine> lines(11);
  for (int k = 0; k < 11; ++k) {
    lines[k].index = k;
    lines[k].time_seconds = 0.1 * k;
    if (k == 0) continue;
    lines[k].step.known = true;
    lines[k].step.rotation = Eigen::Vector3d(0.0, 0.05, 0.0);
    lines[k].step.direction = Eigen::Vector3d(0.0, 0.0, -1.0);
    lines[k].step.heights = 2.0;
  }
  const auto poses = ParseTumTrajectory(TrajectoryText(lines));
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 11u);
  EXPECT_DOUBLE_EQ((*poses)[10].seconds, 1.0);
  const CameraPose& first = (*poses)[0].pose;
  const CameraPose& last = (*poses)[10].pose;
  EXPECT_EQ(first.centre.norm(), 0.0);
  const Eigen::AngleAxisd turn(last.rotation);
  EXPECT_NEAR(turn.angle(), 0.5, 1e-6);
  EXPECT_NEAR(turn.axis()(1), -1.0, 1e-6);  // the camera turns the other way than its picture
  // Chords of 2 on a circle: 10 sides that turn by 0.05 each.
  EXPECT_NEAR(last.centre.norm(), 2.0 * std::sin(0.25) / std::sin(0.025), 1e-4);
}

TEST(TrajectoryFile, WithoutStepsThereIsNone) {
  EXPECT_EQ(TrajectoryText(std::vector<FrameLine>(3)), "");
}

}  // namespace
}  // namespace egosieve::tools
