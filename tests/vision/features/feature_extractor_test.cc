#include "vision/features/feature_extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "tests/vision/features/textured_image.h"
#include "vision/features/corner_detector.h"
#include "vision/features/spread.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

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

TEST(ExtractFeatures, GivesTheNumberAskedForSpreadEvenlyAndInside) {
  const cv::Mat image = TexturedImage(600, 300, 1);
  FeatureOptions options;
  options.count = 1200;
  const auto features = ExtractFeatures(image, options);
  ASSERT_TRUE(features.ok()) << features.status();
  EXPECT_EQ(features->size(), 1200);
  EXPECT_EQ(features->descriptors.size(), 1200u * kSiftDescriptorBytes);
  EXPECT_EQ(features->key_point_count, 600);
  std::map<int, int> in_cell;  // of 8 x 4
  for (const cv::Point2f& p : features->positions) {
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= 599 && p.y <= 299);
    ++in_cell[static_cast<int>(p.x / 75) * 4 + static_cast<int>(p.y / 75)];
  }
  EXPECT_EQ(in_cell.size(), 32u);
  for (const auto& [cell, count] : in_cell) EXPECT_GT(count, 1200 / 32 / 3) << cell;
}

TEST(ExtractFeatures, DefaultNumberFollowsTheArea) {
  EXPECT_EQ(RequestedFeatureCount({}, cv::Size(1242, 375)), 7000);
  EXPECT_EQ(RequestedFeatureCount({}, cv::Size(2484, 375)), 14000);
}

TEST(ExtractFeatures, SameBytesForAnyNumberOfThreads) {
  const cv::Mat image = TexturedImage(400, 250, 2);
  FeatureOptions options;
  options.threads = 1;
  const auto one = ExtractFeatures(image, options);
  ASSERT_TRUE(one.ok());
  for (const int threads : {2, 4}) {
    options.threads = threads;
    const auto more = ExtractFeatures(image, options);
    EXPECT_EQ(more->positions, one->positions);
    EXPECT_EQ(more->descriptors, one->descriptors);
  }
}

TEST(ExtractFeatures, FlatTinyAndWrongImages) {
  const auto flat = ExtractFeatures(cv::Mat(90, 120, CV_8U, cv::Scalar(77)), {});
  ASSERT_TRUE(flat.ok());
  EXPECT_EQ(flat->size(), 0);
  for (const int side : {1, 2, 7, 16, 40}) {
    EXPECT_TRUE(ExtractFeatures(TexturedImage(side, side, 3), {}).ok()) << side;
    EXPECT_TRUE(ExtractFeatures(TexturedImage(300, side, 3), {}).ok()) << side;
  }
  EXPECT_FALSE(ExtractFeatures(cv::Mat(), {}).ok());
  EXPECT_FALSE(ExtractFeatures(cv::Mat(20, 20, CV_8UC3), {}).ok());
  FeatureOptions options;
  options.key_point_share = NAN;
  EXPECT_FALSE(ExtractFeatures(TexturedImage(50, 50, 3), options).ok());
  options = {};
  options.cell_pixels = 0;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
