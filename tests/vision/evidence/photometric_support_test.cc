#include "vision/evidence/photometric_support.h"

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

constexpr int kSide = 64;

// Smooth random texture on the left half, one grey level on the right.
cv::Mat HalfTextured() {
  cv::RNG random(7);
  cv::Mat picture(kSide, kSide, CV_8UC1);
  random.fill(picture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(picture, picture, {5, 5}, 1.2);
  picture.colRange(kSide / 2, kSide).setTo(120);
  return picture;
}

cv::Mat Shifted(const cv::Mat& picture, int right) {
  cv::Mat moved = picture.clone();
  picture.colRange(0, kSide - right).copyTo(moved.colRange(right, kSide));
  return moved;
}

TEST(PhotometricSupport, TextureSaysWhichPlaceIsRight) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const PhotometricSupport support(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_EQ(support.noise_levels(), 1.5);  // the pictures agree: the floor
  EXPECT_GT(*support.LogRatio({12, 30}, {15, 30}, {12, 30}), 20.0);
  // Found in the wrong place, and it stands still: no support.
  EXPECT_EQ(*support.LogRatio({12, 30}, {12, 30}, {15, 30}), 0.0);
}

TEST(PhotometricSupport, NoTextureSaysNothing) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const PhotometricSupport support(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_EQ(*support.LogRatio({50, 30}, {53, 30}, {50, 30}), 0.0);
}

TEST(PhotometricSupport, BrightnessThatChangesEverywhereIsNoDifference) {
  const cv::Mat before = HalfTextured();
  cv::Mat now = Shifted(before, 3) * 0.999;
  now += 20;
  // Clipping touches the brightest pixels alone; a ratio without the change bounds it from above.
  const PhotometricSupport same(before, Shifted(before, 3), {{12, 30}}, {{15, 30}});
  const PhotometricSupport other(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_GT(*other.LogRatio({12, 30}, {15, 30}, {12, 30}),
            0.5 * *same.LogRatio({12, 30}, {15, 30}, {12, 30}));
}

TEST(PhotometricSupport, TheRatioIsThatOfItsDefinition) {
  // P = 0 but for its middle, Q alike, S without: |P - S|^2 less the means by hand.
  cv::Mat before = cv::Mat::zeros(kSide, kSide, CV_8UC1);
  before.at<uint8_t>(20, 20) = 49;
  const PhotometricSupport support(before, before, {{20, 20}}, {{20, 20}});
  // E_0 = 48 (0 - (-1))^2 + (48 - 0)^2 = 48 + 2304, E_1 = 0, v = 1.5^2, kappa = 1/4.
  EXPECT_NEAR(*support.LogRatio({20, 20}, {20, 20}, {40, 40}), 0.25 * 2352 / (2 * 2.25), 1e-3);
}

TEST(PhotometricSupport, NoiseIsThatOfTheFrame) {
  const cv::Mat before = HalfTextured();
  cv::Mat now;
  cv::Mat noise(before.size(), CV_8UC1);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 20);  // standard deviation 5.77
  cv::add(before, noise, now);
  std::vector<cv::Point2f> places;
  for (int y = 8; y < kSide - 8; y += 4) {
    for (int x = 36; x < kSide - 8; x += 4) places.emplace_back(x, y);
  }
  const PhotometricSupport support(before, now, places, places);
  EXPECT_NEAR(support.noise_levels(), 5.77, 0.6);
}

TEST(PhotometricSupport, NothingWhereAPatchLeavesThePicture) {
  const cv::Mat picture = HalfTextured();
  const PhotometricSupport support(picture, picture, {}, {});
  EXPECT_FALSE(support.LogRatio({2, 30}, {15, 30}, {15, 30}).has_value());
  EXPECT_FALSE(support.LogRatio({15, 30}, {15, 62}, {15, 30}).has_value());
  EXPECT_FALSE(support.LogRatio({15, 30}, {15, 30}, {NAN, 30}).has_value());
  EXPECT_TRUE(support.LogRatio({3, 3}, {3, 3}, {3, 3}).has_value());
}

}  // namespace
}  // namespace egosieve::vision
