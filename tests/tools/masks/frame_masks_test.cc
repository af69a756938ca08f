#include "tools/masks/frame_masks.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::tools {
namespace {

TEST(Dilate, ReachesAsFarAsItSaysAndNoFarther) {
  cv::Mat1b masked(41, 61, uint8_t{0});
  masked(20, 30) = 255;
  cv::Mat1w none;
  Dilate(10, masked, none);
  for (int y = 0; y < masked.rows; ++y) {
    for (int x = 0; x < masked.cols; ++x) {
      const int square = (y - 20) * (y - 20) + (x - 30) * (x - 30);
      EXPECT_EQ(masked(y, x) != 0, square <= 100) << x << "," << y;
    }
  }
}

TEST(Dilate, GivesPixelsTheNumberOfTheNearestMover) {
  cv::Mat1w numbers(20, 40, uint16_t{0});
  numbers(10, 10) = 3;
  numbers(10, 20) = 500;
  cv::Mat1b masked = numbers != 0;
  Dilate(8, masked, numbers);
  EXPECT_EQ(numbers(10, 14), 3);
  EXPECT_EQ(numbers(10, 16), 500);
  EXPECT_EQ(numbers(10, 28), 500);
  EXPECT_EQ(numbers(10, 29), 0);
  EXPECT_EQ(cv::countNonZero((numbers != 0) != (masked != 0)), 0);
}

TEST(Dilate, LeavesAPictureWithoutMoversEmpty) {
  cv::Mat1b masked(8, 8, uint8_t{0});
  cv::Mat1w none;
  Dilate(5, masked, none);
  EXPECT_EQ(cv::countNonZero(masked), 0);
}

}  // namespace
}  // namespace egosieve::tools
