#include "vision/trajectory/ground_speed.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "vision/trajectory/camera_step.h"
#include "vision/trajectory/ground_bound.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kSeconds = 0.1;

// Of pictures that show the speed to `deviation` of its logarithm.
SpeedLikelihood Seen(double speed, double deviation) {
  SpeedLikelihood likelihood;
  for (int k = 0; k < kSpeeds; ++k) {
    const double z = std::log(std::max(SpeedAt(k), 1e-6) / speed) / deviation;
    likelihood[k] = std::max(-30.0, -4.0 * z * z);
  }
  return likelihood;
}

// Of a scene at the usual depth, which is seen at this speed.
GroundObservation SceneAt(double speed) { return {.scene_parallax = speed / 12.0}; }

TEST(GroundSpeed, IsNearlyOpenBeforeAPictureShowsIt) {
  GroundSpeed ground;
  EXPECT_LT(ground.Low(), 1.0);
  // Vehicles accelerate, so it is even over the speeds rather than over x.
  for (int k = 0; k < 20; ++k) ground.Advance(kSeconds, {});
  EXPECT_LT(ground.Low(), 0.1 * kGreatestSpeed);
}

TEST(GroundSpeed, IsThatOfASceneAtTheUsualDepthAtFirst) {
  for (const double speed : {2.0, 10.0}) {
    GroundSpeed ground;
    ground.Advance(kSeconds, SceneAt(speed));
    EXPECT_GT(ground.Low(), 0.35 * speed) << "two thirds of the scenes are within a factor of 2";
    EXPECT_LT(ground.Low(), 0.7 * speed);
  }
}

TEST(GroundSpeed, IsNoughtWhereTheSceneDoesNotMove) {
  GroundSpeed ground;
  ground.Advance(kSeconds, SceneAt(0.01));
  EXPECT_LT(ground.Low(), 0.05);
  // Also at once after a stop.
  GroundSpeed stopped;
  for (double speed = 4.0; speed > 0.01; speed -= 0.15) {
    stopped.Advance(kSeconds, SceneAt(speed));
  }
  stopped.Advance(kSeconds, SceneAt(0.01));
  EXPECT_LT(stopped.Low(), 0.05);
}

TEST(GroundSpeed, IsFoundFromPicturesThatAgree) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, {Seen(10.0, 0.2)});
  EXPECT_LE(ground.Low(), 10.0);
  EXPECT_GE(ground.Low(), 8.0);
}

TEST(GroundSpeed, TheFirstPictureCountsInFull) {
  GroundSpeed ground;
  GroundObservation observation = SceneAt(8.0);
  observation.pictures = Seen(8.0, 0.2);
  ground.Advance(kSeconds, observation);
  EXPECT_NEAR(ground.Low(), 8.0, 1.5);
}

TEST(GroundSpeed, IsFoundBySlopesWherePicturesShowNothing) {
  GroundSpeed ground;
  for (int k = 0; k < 20; ++k) ground.Advance(kSeconds, {{}, 10.0});
  EXPECT_LE(ground.Low(), 10.0);
  EXPECT_GE(ground.Low(), 8.0);
}

TEST(GroundSpeed, OneSlopeOfTrafficIsNotTheGround) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, {Seen(10.0, 0.2), 10.0});
  const double before = ground.Low();
  ground.Advance(kSeconds, {Seen(10.0, 0.2), 3.0});
  EXPECT_NEAR(ground.Low(), before, 0.5);
}

// Every third picture shows lane marks, one of them at an alias of the speed.
TEST(GroundSpeed, OutlastsPicturesThatShowNoGround) {
  GroundSpeed ground;
  for (int k = 0; k < 30; ++k) {
    ground.Advance(kSeconds, {k % 3 > 0 ? SpeedLikelihood{} : Seen(k == 15 ? 30.0 : 10.0, 0.2)});
  }
  EXPECT_LE(ground.Low(), 10.5);
  EXPECT_GE(ground.Low(), 7.5);
}

// Lane marks that repeat themselves, in the first pictures.
TEST(GroundSpeed, AFewPicturesOfAnAliasAreOutweighed) {
  GroundSpeed ground;
  for (int k = 0; k < 15; ++k) {
    GroundObservation observation = SceneAt(5.0);
    observation.pictures = Seen(k < 3 ? 25.0 : 5.0, 0.2);
    ground.Advance(kSeconds, observation);
    EXPECT_LT(ground.Low(), 5.5) << k;
  }
  EXPECT_GT(ground.Low(), 4.0);
}

TEST(GroundSpeed, FollowsBraking) {
  GroundSpeed ground;
  double speed = 12.0;
  for (int k = 0; k < 40; ++k, speed -= 0.2) ground.Advance(kSeconds, {Seen(speed, 0.2)});
  EXPECT_LE(ground.Low(), 1.1 * speed);
  EXPECT_GE(ground.Low(), 0.6 * speed);
}

// The pictures come at different intervals, and only the static scene shows that the camera gets
// faster.
TEST(GroundSpeed, FollowsTheScaleOfTheScene) {
  GroundSpeed ground;
  double speed = 10.0, before = kSeconds;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, {Seen(speed, 0.2)});
  GroundSpeed alone = ground;
  for (int k = 0; k < 12; ++k) {
    const double seconds = k % 2 == 0 ? kSeconds : 2.0 * kSeconds;
    ground.SetOnward(1.03 * seconds / before);
    ground.Advance(seconds, {});
    alone.Advance(seconds, {});
    speed *= 1.03;
    before = seconds;
  }
  EXPECT_LE(ground.Low(), speed);
  EXPECT_GE(ground.Low(), 0.7 * speed);
  EXPECT_LT(alone.Low(), 8.0) << "without it less is known";
}

TEST(GroundSpeed, IsForgottenWhereNothingShowsIt) {
  GroundSpeed ground;
  for (int k = 0; k < 20; ++k) ground.Advance(kSeconds, {Seen(10.0, 0.2)});
  ASSERT_GT(ground.Low(), 8.0);
  for (int k = 0; k < 60; ++k) ground.Advance(kSeconds, {});
  EXPECT_LT(ground.Low(), 7.0);
}

// After a long interval a short one: the expected speed is far above the greatest.
TEST(GroundSpeed, EndsAtTheGreatestSpeed) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(3.0, {Seen(40.0, 0.1)});
  ground.SetOnward(1.5);
  ground.Advance(0.3, {});
  EXPECT_GT(ground.Low(), 0.9 * kGreatestSpeed);
}

TEST(GroundSpeed, TakesOnlyValidStates) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, {Seen(10.0, 0.2)});
  ground.SetOnward(0.9);
  GroundSpeed other;
  ASSERT_TRUE(other.Restore(ground.state()));
  EXPECT_EQ(other.Low(), ground.Low());
  GroundSpeed::State wrong = ground.state();
  wrong.probabilities[3] += 0.5;
  EXPECT_FALSE(other.Restore(wrong));
  wrong = ground.state();
  wrong.probabilities[3] = std::nan("");
  EXPECT_FALSE(other.Restore(wrong));
  wrong = ground.state();
  wrong.onward = std::nan("");
  EXPECT_FALSE(other.Restore(wrong));
  ground.Advance(kSeconds, {});
  other.Advance(kSeconds, {});
  EXPECT_EQ(other.Low(), ground.Low()) << "the scale is part of the state";
}

constexpr double kSlope = 0.3;
const Eigen::Vector3d kForward(0.0, 0.0, -1.0);
const Pinhole kCamera = Pinhole::Of({640, 360}, 600.0);

TwoViewMotion Forward(double mean_parallax, double moving_pixels) {
  TwoViewMotion motion;
  motion.found = true;
  motion.translation = kForward;
  motion.mean_parallax = mean_parallax;
  motion.noise_pixels = 0.3;
  motion.noise = 0.3 / 600.0;
  motion.static_share = 0.9;
  motion.moving_scale = moving_pixels / 600.0;
  return motion;
}

// Ground places with a little noise, and as many of a wall at one depth.
std::vector<double> Slopes(int ground, int wall) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> below(0.05, 0.5);
  std::normal_distribution<double> noise(1.0, 0.05);
  std::vector<double> slopes;
  for (int i = 0; i < ground; ++i) slopes.push_back(kSlope * noise(random));
  for (int i = 0; i < wall; ++i) slopes.push_back(0.4 / below(random));
  return slopes;
}

TEST(GroundBound, TheGroundIsFoundBesideAWall) {
  const double alone = GroundSlopeOf(Slopes(200, 0));
  EXPECT_NEAR(alone, kSlope, 0.05 * kSlope);
  EXPECT_NEAR(GroundSlopeOf(Slopes(200, 200)), alone, 0.05 * kSlope);
}

TEST(GroundBound, WithoutAgreementNothingIsKnown) {
  std::vector<double> spread;
  for (int i = 0; i < 200; ++i) spread.push_back(1e-2 * std::pow(1.05, i));
  EXPECT_EQ(GroundSlopeOf(spread), 0.0);
  EXPECT_EQ(GroundSlopeOf(Slopes(20, 0)), 0.0);  // too few
}

TEST(GroundBound, OnlyBelowTheHorizonAndOnTheWayForward) {
  EXPECT_EQ(LeastInverseDepth(kSlope, {0.1, -0.2}, kForward), 0.0);
  EXPECT_NEAR(LeastInverseDepth(kSlope, {0.1, 0.2}, kForward), 0.2 * kSlope, 1e-12);
  EXPECT_EQ(LeastInverseDepth(0.0, {0.1, 0.2}, kForward), 0.0);
  EXPECT_EQ(LeastInverseDepth(kSlope, {0.1, 0.2}, {1.0, 0.0, 0.0}), 0.0);
  // A camera that looks down: the horizon is above the image's middle.
  EXPECT_NEAR(LeastInverseDepth(kSlope, {0.0, 0.0}, Eigen::Vector3d(0, 0.2, -1).normalized()),
              0.2 * kSlope, 1e-12);
}

// The road from 5 to 20 m before a camera 1.5 m above it that moves on by 2 m.
TEST(GroundBound, TheSlopeOfANearRoadIsThatOfItsInverseDepths) {
  const double height = 1.5, step = 2.0;
  std::vector<PointPair> pairs;
  for (double depth = 5.0; depth < 20.0; depth *= 1.01) {
    const double x = std::fmod(137.0 * depth, 4.0) - 2.0;
    const Eigen::Vector2d first = kCamera.Project({x, height, depth});
    const Eigen::Vector2d second = kCamera.Project({x, height, depth - step});
    pairs.push_back({first(0), first(1), second(0), second(1)});
  }
  TwoViewMotion motion = Forward(0.2, 50.0);
  motion.parallax_pixels = 20.0;
  FindGround(pairs, kCamera, motion);
  EXPECT_NEAR(motion.ground_heights, step / height, 1e-3 * step / height);
  motion.ground_slope = SlopeOfBound(motion.ground_heights);
  // No place of the road is farther than its bound, and the farthest is not far above it.
  for (const PointPair& pair : pairs) {
    EXPECT_LT(LikelihoodOf(motion, kCamera, pair).farthest.place(1), pair.y2);
  }
  const PointPair& last = pairs.back();
  EXPECT_GT(LikelihoodOf(motion, kCamera, last).farthest.place(1) - last.y1,
            0.4 * (last.y2 - last.y1));
  // Where a static place would be far away, and where it is not asked, the ground says nothing.
  const PointPair& first = pairs.front();
  EXPECT_NEAR(LikelihoodOf(motion, kCamera, first).farthest.place(1), first.y1, 1e-9);
  EXPECT_NEAR(LikelihoodOf(motion, kCamera, last, false).farthest.place(1), last.y1, 1e-9);
}

TEST(GroundBound, WhatKeepsItsDistanceAheadMoves) {
  // A place on the road ahead that does not move in the image, while the camera does.
  TwoViewMotion motion = Forward(0.05, 20.0);
  const PointPair ahead{380.0, 260.0, 380.0, 260.0};
  const PairLikelihood unbound = LikelihoodOf(motion, kCamera, ahead);
  EXPECT_GT(unbound.log_static, unbound.log_moving);
  motion.ground_slope = kSlope;
  const PairLikelihood bound = LikelihoodOf(motion, kCamera, ahead);
  EXPECT_LT(bound.log_static, bound.log_moving - 5.0);
  EXPECT_GT(bound.farthest.place(1), ahead.y2 + 1.0);  // a static place would have come nearer
  // Above the horizon nothing changes.
  const PointPair sky{380.0, 60.0, 380.0, 60.0};
  EXPECT_GT(LikelihoodOf(motion, kCamera, sky).log_static,
            LikelihoodOf(motion, kCamera, sky).log_moving);
}

const Pinhole kWideCamera = Pinhole::Of({1242, 375}, 720.0);

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
    Eigen::Vector2d place = kWideCamera.Project(point);
    place += Eigen::Vector2d(noise(random), noise(random));
    return place;
  };
  for (int i = 0; i < 400; ++i) {
    const double x = column(random), y = row(random);
    const Eigen::Vector3d point = depth(random) * kWideCamera.Ray(x, y);
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
  const CameraStep step = MeasureStep(of_behind.rotation, views, kWideCamera);
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
  const CameraStep step = MeasureStep(motion.rotation, views, kWideCamera);
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
