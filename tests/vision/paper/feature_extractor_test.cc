#include "vision/paper/feature_extractor.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/testing/status.h"
#include "tests/vision/features/textured_image.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

constexpr int kThreads = 2;

TEST(ExtractFeatures, TheirNumberFollowsTheAreaSpreadEvenlyAndInside) {
  const auto features = Value(ExtractFeatures(TexturedImage(621, 375, 1), kThreads));
  EXPECT_EQ(features.size(), 3500);
  EXPECT_EQ(features.descriptors.size(), 3500u * kSiftDescriptorBytes);
  std::map<int, int> in_cell;  // of 8 x 4
  for (const cv::Point2f& p : features.positions) {
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= 620 && p.y <= 374);
    ++in_cell[static_cast<int>(p.x / 78) * 4 + static_cast<int>(p.y / 94)];
  }
  EXPECT_EQ(in_cell.size(), 32u);
  for (const auto& [cell, count] : in_cell) EXPECT_GT(count, 3500 / 32 / 3) << cell;
}

TEST(ExtractFeatures, SameBytesForAnyNumberOfThreads) {
  const cv::Mat image = TexturedImage(400, 250, 2);
  const auto one = Value(ExtractFeatures(image, 1));
  for (const int threads : {2, 4}) {
    const auto more = ExtractFeatures(image, threads);
    EXPECT_EQ(more->positions, one.positions);
    EXPECT_EQ(more->descriptors, one.descriptors);
  }
}

TEST(ExtractFeatures, FlatTinyAndWrongImages) {
  const auto flat = Value(ExtractFeatures(cv::Mat(90, 120, CV_8U, cv::Scalar(77)), kThreads));
  EXPECT_EQ(flat.size(), 0);
  for (const int side : {1, 2, 7, 16, 40}) {
    EXPECT_TRUE(ExtractFeatures(TexturedImage(side, side, 3), kThreads).ok()) << side;
    EXPECT_TRUE(ExtractFeatures(TexturedImage(300, side, 3), kThreads).ok()) << side;
  }
  EXPECT_FALSE(ExtractFeatures(cv::Mat(), kThreads).ok());
  EXPECT_FALSE(ExtractFeatures(cv::Mat(20, 20, CV_8UC3), kThreads).ok());
}

}  // namespace
}  // namespace egosieve::vision
