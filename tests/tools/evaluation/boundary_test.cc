#include "tools/evaluation/boundary.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::tools {
namespace {

cv::Mat1b Square(int x, int y, int side) {
  cv::Mat1b mask = cv::Mat1b::zeros(100, 100);
  mask(cv::Rect(x, y, side, side)) = 255;
  return mask;
}

TEST(BoundaryTest, BoundaryOfASquareIsAClosedRing) {
  // Pixels with another value to the right, below or right below: for a square of side s at (x, y)
  // these are the outer ring x-1, y-1 and the inner one on the far sides: 4 s in all, less one.
  const cv::Mat1b boundary = BoundaryOf(Square(40, 40, 10));
  EXPECT_EQ(boundary(39, 45), 255);
  EXPECT_EQ(boundary(40, 45), 0);
  EXPECT_EQ(boundary(49, 45), 255);
  EXPECT_EQ(boundary(50, 45), 0);
  EXPECT_EQ(boundary(39, 39), 255);
  EXPECT_EQ(cv::countNonZero(boundary), 40);
}

TEST(BoundaryTest, ShiftsWithinTheBoundCostNothingAndBeyondItEverything) {
  // The radius is ceil(0.008 sqrt(2) 100) = 2 pixels.
  const cv::Mat1b truth = Square(40, 40, 20);
  EXPECT_EQ(BoundaryF(truth, truth)->f, 1.0);
  EXPECT_EQ(BoundaryF(Square(42, 40, 20), truth)->f, 1.0);
  EXPECT_LT(BoundaryF(Square(43, 40, 20), truth)->f, 1.0);
  EXPECT_EQ(BoundaryF(Square(5, 5, 20), truth)->f, 0.0);
}

TEST(BoundaryTest, PrecisionAndRecallByHand) {
  // Two far squares are called where one of them is real.
  const cv::Mat1b truth = Square(10, 10, 10), both = truth | Square(60, 60, 10);
  const BoundaryScore score = *BoundaryF(both, truth);
  EXPECT_EQ(score.precision, 0.5);
  EXPECT_EQ(score.recall, 1.0);
  EXPECT_EQ(score.f, 2.0 / 3.0);
}

TEST(BoundaryTest, EmptyMasks) {
  const cv::Mat1b nothing = cv::Mat1b::zeros(100, 100), square = Square(10, 10, 10);
  EXPECT_EQ(BoundaryF(nothing, nothing)->f, 1.0);
  EXPECT_EQ(BoundaryF(square, nothing)->f, 0.0);
  EXPECT_EQ(BoundaryF(nothing, square)->f, 0.0);
}

TEST(BoundaryTest, VoidPixelsDoNotCount) {
  const cv::Mat1b truth = Square(10, 10, 10), both = truth | Square(60, 60, 10);
  EXPECT_EQ(BoundaryF(both, truth, Square(55, 55, 20))->f, 1.0);
}

TEST(BoundaryTest, SizesMustAgree) {
  EXPECT_EQ(BoundaryF(cv::Mat1b::zeros(3, 4), cv::Mat1b::zeros(4, 3)).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace egosieve::tools
