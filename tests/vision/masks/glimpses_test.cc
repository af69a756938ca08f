#include "vision/masks/glimpses.h"

#include <gtest/gtest.h>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 30, kHeight = 10;

// 7 in the left third, 8 in the right one.
cv::Mat1w TwoMovers() {
  cv::Mat1w numbers(kHeight, kWidth, uint16_t{0});
  numbers(cv::Rect(0, 0, 10, kHeight)) = 7;
  numbers(cv::Rect(20, 0, 10, kHeight)) = 8;
  return numbers;
}

TEST(DropGlimpses, DropsWhatTheNextFrameHasNowhere) {
  cv::Mat1w next = TwoMovers();
  next(cv::Rect(0, 0, 10, kHeight)) = 0;
  cv::Mat1w numbers = TwoMovers();
  DropGlimpses({7, 8, 9}, next, numbers);
  EXPECT_EQ(cv::countNonZero(numbers == 7), 0);
  EXPECT_EQ(cv::countNonZero(numbers == 8), 10 * kHeight);
}

TEST(DropGlimpses, WhatWasSeenBeforeStays) {
  cv::Mat1w numbers = TwoMovers();
  DropGlimpses({8}, cv::Mat1w(kHeight, kWidth, uint16_t{0}), numbers);
  EXPECT_EQ(cv::countNonZero(numbers == 7), 10 * kHeight);
  EXPECT_EQ(cv::countNonZero(numbers == 8), 0);
}

TEST(DropGlimpses, WhatJoinsAnotherMoverStays) {
  for (const int columns : {4, 5}) {
    cv::Mat1w next(kHeight, kWidth, uint16_t{0});
    next(cv::Rect(0, 0, columns, kHeight)) = 3;
    cv::Mat1w numbers = TwoMovers();
    DropGlimpses({7}, next, numbers);
    EXPECT_EQ(cv::countNonZero(numbers == 7), columns == 5 ? 10 * kHeight : 0) << columns;
  }
}

}  // namespace
}  // namespace egosieve::vision
