#include "vision/trajectory/ground_speed.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "vision/trajectory/ground_bound.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kSeconds = 0.1;

// Of pictures that show the speed to `deviation` of its logarithm.
SpeedLikelihood Seen(double speed, double deviation) {
  SpeedLikelihood likelihood;
  for (int k = 0; k < kSpeeds; ++k) {
    const double z = std::log(SpeedAt(k) / speed) / deviation;
    likelihood[k] = std::max(-30.0, -1.5 * z * z);
  }
  likelihood[kSpeeds] = -12.0;
  return likelihood;
}

TEST(GroundSpeed, IsNotKnownBeforeAPictureShowsIt) {
  GroundSpeed ground;
  EXPECT_EQ(ground.Low(), 0.0);
  for (int k = 0; k < 20; ++k) ground.Advance(kSeconds, {});
  EXPECT_EQ(ground.Low(), 0.0);
}

TEST(GroundSpeed, IsFoundFromPicturesThatAgree) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, Seen(10.0, 0.2));
  EXPECT_LE(ground.Low(), 10.0);
  EXPECT_GE(ground.Low(), 8.0);
}

TEST(GroundSpeed, FollowsBraking) {
  GroundSpeed ground;
  double speed = 12.0;
  for (int k = 0; k < 40; ++k, speed -= 0.2) ground.Advance(kSeconds, Seen(speed, 0.2));
  EXPECT_LE(ground.Low(), 1.1 * speed);
  EXPECT_GE(ground.Low(), 0.6 * speed);
}

TEST(GroundSpeed, IsForgottenWhereNothingShowsIt) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, Seen(10.0, 0.2));
  ASSERT_GT(ground.Low(), 0.0);
  for (int k = 0; k < 30; ++k) ground.Advance(kSeconds, {});
  EXPECT_EQ(ground.Low(), 0.0);
}

TEST(GroundSpeed, TakesOnlyProbabilities) {
  GroundSpeed ground;
  for (int k = 0; k < 10; ++k) ground.Advance(kSeconds, Seen(10.0, 0.2));
  GroundSpeed other;
  EXPECT_TRUE(other.Restore(ground.probabilities()));
  EXPECT_EQ(other.Low(), ground.Low());
  GroundSpeed::Probabilities wrong = ground.probabilities();
  wrong[3] += 0.5;
  EXPECT_FALSE(other.Restore(wrong));
  wrong = ground.probabilities();
  wrong[3] = std::nan("");
  EXPECT_FALSE(other.Restore(wrong));
  EXPECT_EQ(other.Low(), ground.Low());
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
std::vector<BelowHorizon> Places(int ground, int wall) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> below(0.05, 0.5);
  std::normal_distribution<double> noise(1.0, 0.05);
  std::vector<BelowHorizon> places;
  for (int i = 0; i < ground; ++i) {
    const double b = below(random);
    places.push_back({kSlope * b * noise(random), b});
  }
  for (int i = 0; i < wall; ++i) places.push_back({0.4, below(random)});
  return places;
}

TEST(GroundBound, TheGroundIsFoundBesideAWall) {
  const double alone = GroundSlopeOf(Places(200, 0));
  EXPECT_GT(alone, 0.5 * kSlope);
  EXPECT_LT(alone, 0.7 * kSlope);
  EXPECT_NEAR(GroundSlopeOf(Places(200, 200)), alone, 0.05 * kSlope);
}

TEST(GroundBound, WithoutAgreementNothingIsKnown) {
  std::vector<BelowHorizon> spread;
  for (int i = 0; i < 200; ++i) spread.push_back({1e-3 * std::pow(1.05, i), 0.1});
  EXPECT_EQ(GroundSlopeOf(spread), 0.0);
  EXPECT_EQ(GroundSlopeOf(Places(20, 0)), 0.0);  // too few
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
  EXPECT_NEAR(motion.ground_slope, 0.6 * step / height, 1e-3 * step / height);
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

}  // namespace
}  // namespace egosieve::vision
