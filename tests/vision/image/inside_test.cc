#include "vision/image/inside.h"

#include <cmath>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

TEST(IsInside, UpToTheCentresOfTheOutermostPixels) {
  const cv::Size picture(4, 3);
  EXPECT_TRUE(IsInside(0.0, 0.0, picture));
  EXPECT_TRUE(IsInside(3.0, 2.0, picture));
  EXPECT_TRUE(IsInside(1.5, 0.5, picture));
  EXPECT_FALSE(IsInside(-1e-9, 1.0, picture));
  EXPECT_FALSE(IsInside(1.0, -1e-9, picture));
  EXPECT_FALSE(IsInside(3.0 + 1e-9, 1.0, picture));
  EXPECT_FALSE(IsInside(1.0, 2.0 + 1e-9, picture));
}

TEST(IsInside, IsFalseForNanAndEmptyPictures) {
  const double nan = std::nan("");
  EXPECT_FALSE(IsInside(nan, 0.0, {4, 3}));
  EXPECT_FALSE(IsInside(0.0, nan, {4, 3}));
  EXPECT_FALSE(IsInside(0.0, 0.0, {0, 0}));
}

}  // namespace
}  // namespace egosieve::vision
