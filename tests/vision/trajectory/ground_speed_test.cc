#include "vision/trajectory/ground_speed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

}  // namespace
}  // namespace egosieve::vision
