#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gtest/gtest.h"
#include "vision/labelling/gap_choice.h"
#include "vision/labelling/lines_along_travel.h"

namespace egosieve::vision {
namespace {

const cv::Size kSize(320, 160);
const Eigen::Vector3d kAhead(0.0, 0.0, 1.0);

Pinhole Camera() { return Pinhole::Of(kSize, 200.0); }

// A bright strip, blurred as a camera does.
cv::Mat StripFrom(cv::Point2d from, cv::Point2d to) {
  cv::Mat grey(kSize, CV_8UC1, cv::Scalar(80));
  cv::line(grey, from, to, cv::Scalar(220), 6, cv::LINE_AA);
  cv::GaussianBlur(grey, grey, {}, 1.0);
  return grey;
}

cv::Point2f Between(cv::Point2d from, cv::Point2d to) { return (from + to) * 0.5; }

TEST(LinesAlongTravel, ALaneLineIsOneAndAStopLineIsNot) {
  const Pinhole camera = Camera();
  const cv::Point2d vanishing(camera.centre_x, camera.centre_y);
  const cv::Point2d near(60.0, 150.0), far = vanishing + (near - vanishing) * 0.2;
  const LinesAlongTravel lane(StripFrom(near, far), camera, kAhead);
  EXPECT_TRUE(lane.Contain(Between(near, far)));
  EXPECT_FALSE(lane.Contain({250.0F, 120.0F})) << "blank";

  const cv::Point2d left(60.0, 120.0), right(160.0, 120.0);
  EXPECT_FALSE(
      LinesAlongTravel(StripFrom(left, right), camera, kAhead).Contain(Between(left, right)));
}

TEST(LinesAlongTravel, TheDirectionOfTravelCounts) {
  const Pinhole camera = Camera();
  // Towards a point 100 pixels to the right of the middle.
  const Eigen::Vector3d travel = Eigen::Vector3d(0.5, 0.0, 1.0).normalized();
  const cv::Point2d vanishing(camera.centre_x + 100.0, camera.centre_y);
  const cv::Point2d near(60.0, 150.0), far = vanishing + (near - vanishing) * 0.2;
  const cv::Mat grey = StripFrom(near, far);
  EXPECT_TRUE(LinesAlongTravel(grey, camera, travel).Contain(Between(near, far)));
  EXPECT_FALSE(LinesAlongTravel(grey, camera, kAhead).Contain(Between(near, far)));
}

TEST(LinesAlongTravel, NoneAboveTheHorizon) {
  const Pinhole camera = Camera();
  const cv::Point2d vanishing(camera.centre_x, camera.centre_y);
  const cv::Point2d near(60.0, 10.0), far = vanishing + (near - vanishing) * 0.2;
  EXPECT_FALSE(LinesAlongTravel(StripFrom(near, far), camera, kAhead).Contain(Between(near, far)));
}

// The camera moves ahead by a tenth of its height above the ground.
TEST(SeemsNoNearerThanGround, TellsTheGroundFromWhatStandsOnIt) {
  const Pinhole camera = Camera();
  TwoViewMotion motion;
  motion.found = true;
  motion.translation = -kAhead;
  motion.mean_parallax = 0.05;
  motion.noise = 0.5 / camera.focal_pixels;
  motion.static_share = 0.9;
  motion.moving_scale = 10.0 / camera.focal_pixels;
  motion.noise_pixels = 0.5;
  const auto seen = [&](double share_of_ground) {
    const cv::Point2f now(100.0F, 140.0F);
    const Eigen::Vector3d ray = camera.Ray(now.x, now.y);
    // The ground is one height below the camera; X = ray / r in heights.
    const double inverse_depth = share_of_ground * ray(1);
    const Eigen::Vector3d point = ray / inverse_depth + 0.1 * motion.translation;
    const Eigen::Vector2d there = camera.Project(point);
    return SeemsNoNearerThanGround(motion, camera, now,
                                   {static_cast<float>(there(0)), static_cast<float>(there(1))});
  };
  EXPECT_FALSE(seen(0.5)) << "the ground is not known";
  motion.ground_heights = 0.1;
  EXPECT_TRUE(seen(0.1));
  EXPECT_TRUE(seen(1.0));
  EXPECT_FALSE(seen(1.4));
  EXPECT_FALSE(seen(3.0));
}

constexpr int kLongest = 5;

// What the gap settles at where a picture brings so much parallax.
void Observe(double parallax_pixels, int gap, int longest, GapState& state) {
  ObserveParallax(parallax_pixels, gap, longest, kCalibratedGap, state);
}

int SettledGap(double pixels_a_picture, GapState state = {}) {
  for (int t = 0; t < 60; ++t) {
    Observe(pixels_a_picture * state.gap, state.gap, kLongest, state);
  }
  return state.gap;
}

// Three pixels of parallax are wanted.
TEST(GapChoice, LessParallaxMakesItLonger) {
  EXPECT_EQ(SettledGap(4.0), 1);  // driving
  EXPECT_EQ(SettledGap(2.6), 1);
  EXPECT_EQ(SettledGap(1.8), 2);
  EXPECT_EQ(SettledGap(1.1), 3);
  EXPECT_EQ(SettledGap(0.78), 4);        // walking pace, in small pictures
  EXPECT_EQ(SettledGap(0.2), kLongest);  // in the hand
  EXPECT_EQ(SettledGap(0.0), kLongest);  // standing
}

// Of a model that is selected, less than 0.35 px of parallax is none.
TEST(GapChoice, SelectedModelsGainNothingWithoutParallax) {
  for (const double pixels : {0.2, 0.0}) {
    GapState state;
    for (int t = 0; t < 60; ++t) {
      ObserveParallax(pixels * state.gap, state.gap, kLongest, kSelectedModelGap, state);
    }
    EXPECT_EQ(state.gap, 1) << pixels;
  }
}

TEST(GapChoice, StaysWhereItIsNearABorder) {
  GapState state;
  for (int t = 0; t < 60; ++t) Observe(1.5 * state.gap, state.gap, kLongest, state);
  ASSERT_EQ(state.gap, 2);
  // 3 / p is 1.9 and 2.2 in turn.
  for (int t = 0; t < 20; ++t) {
    Observe((t % 2 == 0 ? 1.58 : 1.36) * state.gap, state.gap, kLongest, state);
    EXPECT_EQ(state.gap, 2) << t;
  }
  EXPECT_EQ(SettledGap(6.0, state), 1);
}

TEST(GapChoice, NonsenseChangesNothing) {
  GapState state;
  Observe(3.0, 3, kLongest, state);
  const GapState before = state;
  Observe(std::nan(""), 1, kLongest, state);
  Observe(INFINITY, 1, kLongest, state);
  Observe(-1.0, 1, kLongest, state);
  Observe(1.0, 0, kLongest, state);
  EXPECT_EQ(state.gap, before.gap);
  EXPECT_EQ(state.log_parallax, before.log_parallax);
}

}  // namespace
}  // namespace egosieve::vision
