#include "vision/masks/tonal_range.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::vision {
namespace {

constexpr int kSide = 400;  // every fourth pixel: 10,000

TEST(TonalRange, FewPixelsLieOutside) {
  cv::Mat3b picture(kSide, kSide, cv::Vec3b(60, 70, 50));
  picture(cv::Rect(0, 0, kSide, 100)).setTo(cv::Vec3b(30, 40, 20));
  picture(cv::Rect(0, 300, kSide, 100)).setTo(cv::Vec3b(90, 80, 100));
  picture(0, 0) = {0, 0, 0};
  picture(4, 4) = {255, 255, 255};
  const TonalRange range = TonalRangeOf({picture});
  EXPECT_EQ(range.low, 20.0);
  EXPECT_EQ(range.high, 100.0);
  EXPECT_DOUBLE_EQ(range.Gain(), 127.5 / 80.0);
  const cv::Mat3b stretched = Stretched(picture, range);
  EXPECT_EQ(stretched(10, 10), cv::Vec3b(16, 32, 0));
  EXPECT_EQ(stretched(390, 10), cv::Vec3b(112, 96, 128));
  EXPECT_EQ(stretched(4, 4), cv::Vec3b(255, 255, 255));
}

TEST(TonalRange, IsOfAllPictures) {
  const cv::Mat3b dark(8, 8, cv::Vec3b(10, 10, 10)), bright(8, 8, cv::Vec3b(130, 130, 130));
  const TonalRange range = TonalRangeOf({dark, bright});
  EXPECT_EQ(range.low, 10.0);
  EXPECT_EQ(range.high, 130.0);
}

TEST(TonalRange, HalfOfTheLevelsAreEnough) {
  EXPECT_DOUBLE_EQ((TonalRange{10.0, 138.0}.Gain()), 1.0);
  const cv::Mat3b picture(2, 2, cv::Vec3b(20, 30, 40));
  EXPECT_EQ(Stretched(picture, {10.0, 138.0})(0, 0), picture(0, 0));
}

TEST(TonalRange, NoiseOfABlankPictureIsNotStretchedToTheWhole) {
  const TonalRange range = TonalRangeOf({cv::Mat3b(8, 8, cv::Vec3b(77, 77, 77))});
  EXPECT_EQ(range.low, 77.0);
  EXPECT_EQ(range.high, 77.0);
  EXPECT_EQ(range.Gain(), kMostGain);
}

}  // namespace
}  // namespace egosieve::vision
