#include "tools/segment/trajectory_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

namespace egosieve::tools {
namespace {

// Rows of seconds, centre and quaternion (x, y, z, w); lines with # are comments.
std::vector<std::array<double, 8>> Poses(const std::string& text) {
  std::vector<std::array<double, 8>> poses;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream numbers(line);
    for (double& number : poses.emplace_back()) numbers >> number;
    EXPECT_FALSE(numbers.fail()) << line;
  }
  return poses;
}

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
  const auto poses = Poses(TrajectoryText(lines));
  ASSERT_EQ(poses.size(), 11u);
  EXPECT_DOUBLE_EQ(poses[10][0], 1.0);
  const auto centre = [&](int k) { return Eigen::Vector3d(poses[k][1], poses[k][2], poses[k][3]); };
  EXPECT_EQ(centre(0).norm(), 0.0);
  const Eigen::AngleAxisd turn(
      Eigen::Quaterniond(poses[10][7], poses[10][4], poses[10][5], poses[10][6]).normalized());
  EXPECT_NEAR(turn.angle(), 0.5, 1e-6);
  EXPECT_NEAR(turn.axis()(1), -1.0, 1e-6);  // the camera turns the other way than its picture
  // Chords of 2 on a circle: 10 sides that turn by 0.05 each.
  EXPECT_NEAR(centre(10).norm(), 2.0 * std::sin(0.25) / std::sin(0.025), 1e-4);
}

TEST(TrajectoryFile, WithoutStepsThereIsNone) {
  EXPECT_EQ(TrajectoryText(std::vector<FrameLine>(3)), "");
}

}  // namespace
}  // namespace egosieve::tools
