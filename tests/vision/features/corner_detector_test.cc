#include "vision/features/corner_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "vision/features/spread.h"

namespace egosieve::vision {
namespace {

TEST(DetectCorners, FindsTheCornersOfARectangleToAPixel) {
  cv::Mat image(80, 100, CV_8U, cv::Scalar(40));
  image(cv::Rect(30, 20, 40, 35)).setTo(200);
  const std::vector<Corner> corners = DetectCorners(image, 1e-4F, 3);
  ASSERT_EQ(corners.size(), 4u);
  for (const cv::Point2f expected :
       {cv::Point2f(30, 20), cv::Point2f(69, 20), cv::Point2f(30, 54), cv::Point2f(69, 54)}) {
    EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](const Corner& corner) {
      return std::hypot(corner.position.x - expected.x, corner.position.y - expected.y) < 1.5;
    })) << expected;
  }
}

TEST(DetectCorners, NothingInFlatOrTinyImages) {
  EXPECT_TRUE(DetectCorners(cv::Mat(50, 50, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
  EXPECT_TRUE(DetectCorners(cv::Mat(5, 5, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
}

TEST(SpreadOverGrid, TakesTheStrongestOfEachCellFirst) {
  std::vector<cv::Point2f> positions;
  std::vector<float> responses;
  for (int i = 0; i < 100; ++i) {  // a crowd of strong ones in one corner
    positions.emplace_back(0.1F * i, 5.0F);
    responses.push_back(100.0F + i);
  }
  for (int cell = 1; cell < 10; ++cell) {  // one weak one in each other cell
    positions.emplace_back(20.0F * cell + 10.0F, 10.0F);
    responses.push_back(1.0F);
  }
  const auto chosen = SpreadOverGrid(positions, responses, cv::Size(200, 20), 20, 10);
  ASSERT_EQ(chosen.size(), 10u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  EXPECT_EQ(chosen[0], 99) << "the strongest of the crowd";
  for (int cell = 1; cell < 10; ++cell) EXPECT_EQ(chosen[cell], 99 + cell);
  EXPECT_EQ(SpreadOverGrid(positions, responses, cv::Size(200, 20), 20, 1000).size(), 109u);
  EXPECT_TRUE(SpreadOverGrid({}, {}, cv::Size(200, 20), 20, 5).empty());
}

}  // namespace
}  // namespace egosieve::vision
