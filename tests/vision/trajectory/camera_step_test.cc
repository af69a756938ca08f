#include "vision/trajectory/camera_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egosieve::vision {
namespace {

const Pinhole kCamera = Pinhole::Of({1242, 375}, 720.0);

TwoViewMotion Motion(const Eigen::Isometry3d& second_from_first) {
  TwoViewMotion motion;
  motion.found = true;
  motion.rotation = second_from_first.rotation();
  motion.translation = second_from_first.translation().normalized();
  motion.mean_parallax = 0.1;
  motion.noise_pixels = 0.2;
  motion.noise = 0.2 / 720.0;
  motion.parallax_pixels = 5.0;
  motion.static_share = 0.9;
  motion.moving_scale = 100.0 / 720.0;
  return motion;
}

Eigen::Isometry3d Step(double metres, double turn) {
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  step.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()).toRotationMatrix();
  step.translation() = Eigen::Vector3d(0.0, 0.0, -metres);
  return step;
}

// A street seen from the frame between the two pairs; places with noise.
StepViews Street(const Eigen::Isometry3d& behind, const Eigen::Isometry3d& ahead,
                 const TwoViewMotion& motion_behind, const TwoViewMotion& motion_ahead) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> depth(6.0, 40.0), column(200.0, 1000.0), row(60.0, 320.0);
  std::normal_distribution<double> noise(0.0, 0.2);
  StepViews views;
  views.behind = &motion_behind;
  views.ahead = &motion_ahead;
  const auto project = [&](const Eigen::Vector3d& point) {
    Eigen::Vector2d place = kCamera.Project(point);
    place += Eigen::Vector2d(noise(random), noise(random));
    return place;
  };
  for (int i = 0; i < 400; ++i) {
    const double x = column(random), y = row(random);
    const Eigen::Vector3d point = depth(random) * kCamera.Ray(x, y);
    const Eigen::Vector2d a = project(behind.inverse() * point), b = project(ahead * point);
    views.places.push_back({{a(0), a(1), x, y}, {x, y, b(0), b(1)}});
  }
  return views;
}

TEST(CameraStep, TheNextStepIsLongerByTheAcceleration) {
  // 1.0 m behind, then five steps that are 2 % longer each.
  double ahead_metres = 0.0;
  for (int k = 1; k <= 5; ++k) ahead_metres += std::pow(1.02, k);
  const Eigen::Isometry3d behind = Step(1.0, 0.01), ahead = Step(ahead_metres, -0.03);
  const TwoViewMotion of_behind = Motion(behind), of_ahead = Motion(ahead);
  StepViews views = Street(behind, ahead, of_behind, of_ahead);
  views.pictures_ahead = 5;
  const CameraStep step = MeasureStep(of_behind.rotation, views, kCamera);
  EXPECT_TRUE(step.known);
  EXPECT_NEAR(step.onward, 1.02, 0.005);
  EXPECT_NEAR(step.rotation(1), 0.01, 1e-9);
  EXPECT_NEAR(step.direction(2), -1.0, 1e-9);
  EXPECT_EQ(step.heights, 0.0);
}

TEST(CameraStep, WithoutParallaxTheCameraDoesNotTravel) {
  const Eigen::Isometry3d still = Step(1e-6, 0.02);
  TwoViewMotion motion = Motion(still);
  motion.parallax_pixels = 0.1;
  StepViews views;
  views.behind = &motion;
  const CameraStep step = MeasureStep(motion.rotation, views, kCamera);
  EXPECT_TRUE(step.known);
  EXPECT_EQ(step.direction.norm(), 0.0);
  EXPECT_EQ(step.onward, 0.0);
}

// Steps of `lengths`, turning, with the ratios of the lengths.
std::vector<CameraStep> Steps(const std::vector<double>& lengths) {
  std::vector<CameraStep> steps(lengths.size());
  for (size_t k = 1; k < lengths.size(); ++k) {
    steps[k].known = true;
    steps[k].rotation = Eigen::Vector3d(0.0, 0.02, 0.001);
    steps[k].direction = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
    if (k + 1 < lengths.size()) steps[k].onward = lengths[k + 1] / lengths[k];
  }
  return steps;
}

Eigen::Isometry3d Exact(const std::vector<CameraStep>& steps, const std::vector<double>& lengths) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (size_t k = 1; k < steps.size(); ++k) {
    Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
    step.linear() =
        Eigen::AngleAxisd(steps[k].rotation.norm(), steps[k].rotation.normalized()).matrix();
    step.translation() = lengths[k] * steps[k].direction;
    pose = pose * step.inverse();
  }
  return pose;
}

TEST(CameraStep, AChainOfStepsIsTheTrajectory) {
  std::vector<double> lengths = {1.0};
  for (int k = 1; k < 40; ++k) lengths.push_back(std::pow(1.03, k - 1));
  const std::vector<CameraStep> steps = Steps(lengths);
  const std::vector<Eigen::Isometry3d> poses = ChainSteps(steps);
  ASSERT_EQ(poses.size(), steps.size());
  EXPECT_TRUE(poses[0].isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(poses.back().isApprox(Exact(steps, lengths), 1e-9));
}

TEST(CameraStep, TheGroundGivesTheUnitAndStopsTheDrift) {
  // Every ratio is 1 % too large; the ground is seen in every tenth frame.
  const std::vector<double> lengths(200, 0.7);
  std::vector<CameraStep> steps = Steps(lengths);
  for (CameraStep& step : steps) step.onward *= 1.01;
  for (size_t k = 5; k < steps.size(); k += 10) steps[k].heights = 0.7;
  const std::vector<Eigen::Isometry3d> poses = ChainSteps(steps);
  for (const size_t k : {20, 100, 180}) {
    const double length = (poses[k].translation() - poses[k - 1].translation()).norm();
    EXPECT_NEAR(length, 0.7, 0.07) << k;
  }
}

TEST(CameraStep, WhatIsNotKnownGoesOnAsBefore) {
  std::vector<CameraStep> steps = Steps(std::vector<double>(10, 1.0));
  steps[5] = CameraStep();
  const std::vector<Eigen::Isometry3d> poses = ChainSteps(steps);
  const Eigen::Isometry3d before = poses[3].inverse() * poses[4],
                          at = poses[4].inverse() * poses[5];
  EXPECT_TRUE(at.isApprox(before, 1e-9));
  EXPECT_TRUE(ChainSteps({}).empty());
}

}  // namespace
}  // namespace egosieve::vision
