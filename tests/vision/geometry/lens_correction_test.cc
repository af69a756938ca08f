#include "vision/geometry/lens_correction.h"

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 320, kHeight = 200;
constexpr double kMiddleX = 0.5 * (kWidth - 1), kMiddleY = 0.5 * (kHeight - 1);

// Off-centre, with two focal lengths and k1, k2, p1, p2.
Lens Barrel() {
  Lens lens{180.0, 190.0, 166.5, 95.5};
  lens.distortion = {-0.2, 0.03, 0.001, -0.002};
  return lens;
}

Lens Fisheye() {
  Lens lens{150.0, 150.0, 160.0, 100.0, true};
  lens.distortion = {0.05, -0.01};
  return lens;
}

LensCorrection CorrectionOf(const Lens& lens) {
  return *LensCorrection::Create(lens, {kWidth, kHeight});
}

// A smooth pattern over the rays.
double Brightness(double u, double v) {
  return 128.0 + 90.0 * std::sin(9.0 * u) * std::cos(7.0 * v);
}

// What the lens shows, by bisection of its projection on the way from the axis: other code than
// that of LensCorrection, for lenses without p1 and p2.
cv::Mat1b PictureThrough(const Lens& lens) {
  cv::Mat1b picture(kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double a = (x + 0.5 - lens.cx) / lens.fx, b = (y + 0.5 - lens.cy) / lens.fy;
      double near = 0.0, far = 4.0;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (near + far);
        const auto [px, py] = lens.Project(middle * a, middle * b);
        const double reached = std::hypot((px - lens.cx) / lens.fx, (py - lens.cy) / lens.fy);
        (reached < std::hypot(a, b) ? near : far) = middle;
      }
      picture(y, x) = static_cast<uint8_t>(std::lround(Brightness(near * a, near * b)));
    }
  }
  return picture;
}

TEST(LensCorrection, APinholePictureStays) {
  const LensCorrection correction = CorrectionOf({200.0, 200.0, 160.0, 100.0});
  EXPECT_TRUE(correction.IsIdentity());
  EXPECT_NEAR(correction.focal_pixels(), 200.0, 1e-9);
  EXPECT_FALSE(CorrectionOf({200.0, 200.0, 162.0, 100.0}).IsIdentity());
  EXPECT_FALSE(CorrectionOf(Barrel()).IsIdentity());
}

TEST(LensCorrection, PlacesAreThoseOfTheirRays) {
  for (const Lens& lens : {Barrel(), Fisheye()}) {
    const LensCorrection correction = CorrectionOf(lens);
    for (const double u : {-0.6, -0.1, 0.0, 0.4}) {
      for (const double v : {-0.3, 0.0, 0.35}) {
        const double f = correction.focal_pixels();
        const cv::Point2d place = correction.Distort({kMiddleX + f * u, kMiddleY + f * v});
        const auto [x, y] = lens.Project(u, v);
        EXPECT_NEAR(place.x, x - 0.5, 1e-9);
        EXPECT_NEAR(place.y, y - 0.5, 1e-9);
      }
    }
  }
}

// The middle of each side is in the pinhole picture, and one of them at its border.
TEST(LensCorrection, ShowsTheMiddlesOfAllSides) {
  for (const Lens& lens : {Barrel(), Fisheye()}) {
    const LensCorrection correction = CorrectionOf(lens);
    const cv::Point2d left = correction.Distort({0.0, kMiddleY}),
                      right = correction.Distort({kWidth - 1.0, kMiddleY}),
                      top = correction.Distort({kMiddleX, 0.0}),
                      bottom = correction.Distort({kMiddleX, kHeight - 1.0});
    const double beyond[] = {-left.x, right.x - (kWidth - 1), -top.y, bottom.y - (kHeight - 1)};
    EXPECT_NEAR(*std::min_element(std::begin(beyond), std::end(beyond)), 0.0, 1.0);
  }
}

TEST(LensCorrection, PicturesAreThoseOfAPinholeCamera) {
  Lens barrel = Barrel();
  barrel.distortion[2] = barrel.distortion[3] = 0.0;
  for (const Lens& lens : {barrel, Fisheye()}) {
    const LensCorrection correction = CorrectionOf(lens);
    const cv::Mat1b corrected = correction.Correct(PictureThrough(lens));
    cv::Mat1b blank = correction.CorrectMask({});
    cv::dilate(blank, blank, cv::Mat());  // pixels at the border mix with its repetition
    int compared = 0;
    for (int y = 1; y < kHeight - 1; ++y) {
      for (int x = 1; x < kWidth - 1; ++x) {
        if (blank(y, x) != 0) continue;
        ++compared;
        const double f = correction.focal_pixels();
        ASSERT_NEAR(corrected(y, x), Brightness((x - kMiddleX) / f, (y - kMiddleY) / f), 1.5)
            << x << ", " << y;
      }
    }
    EXPECT_GT(compared, kWidth * kHeight / 2);
  }
}

TEST(LensCorrection, MasksGoThereAndBack) {
  const LensCorrection correction = CorrectionOf(Barrel());
  cv::Mat1b disc = cv::Mat1b::zeros(kHeight, kWidth);
  cv::circle(disc, {90, 60}, 30, cv::Scalar(255), cv::FILLED);
  const cv::Mat1b there = correction.CorrectMask(disc) & ~correction.CorrectMask({});
  const cv::Mat1b back = correction.DistortMask(there);
  EXPECT_LT(cv::countNonZero(back != disc), 60);
  EXPECT_GT(cv::countNonZero(there != disc), 200);
}

// k1 = -0.5 turns back at r = 0.82, where the picture is 0.54 focal lengths from the axis.
TEST(LensCorrection, WhatLiesBeyondTheFoldIsBlank) {
  Lens lens{320.0, 320.0, 160.0, 100.0};
  lens.distortion[0] = -0.5;
  const LensCorrection correction = CorrectionOf(lens);
  const cv::Mat1b blank = correction.CorrectMask({});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double r = std::hypot(x - kMiddleX, y - kMiddleY) / correction.focal_pixels();
      if (r > 0.83) {
        ASSERT_EQ(blank(y, x), 255) << x << ", " << y;
      }
    }
  }
  EXPECT_LT(cv::countNonZero(blank), kWidth * kHeight / 4);
}

TEST(LensCorrection, RefusesWhatNoPinholeCameraShows) {
  Lens folded{180.0, 180.0, 160.0, 100.0};
  folded.distortion[0] = -3.0;
  EXPECT_EQ(LensCorrection::Create(folded, {kWidth, kHeight}).status().code(),
            absl::StatusCode::kInvalidArgument);
  const Lens wide{100.0, 100.0, 160.0, 100.0, true};  // 92 degrees from the axis
  EXPECT_THAT(LensCorrection::Create(wide, {kWidth, kHeight}).status().message(),
              testing::HasSubstr("75 degrees"));
}

}  // namespace
}  // namespace egosieve::vision
