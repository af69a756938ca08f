#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/features/textured_image.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"
#include "vision/paper/neighbour_agreement.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

TEST(ExtractFeatures, TheirNumberFollowsTheAreaSpreadEvenlyAndInside) {
  const auto features = Value(ExtractFeatures(TexturedImage(621, 375, 1)));
  EXPECT_EQ(features.size(), 3500);
  EXPECT_EQ(features.descriptors.size(), cv::Size(128, 3500));
  EXPECT_EQ(features.descriptors.type(), CV_32F);
  std::map<int, int> in_cell;  // of 8 x 4
  for (const cv::Point2f& p : features.positions) {
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= 620 && p.y <= 374);
    ++in_cell[static_cast<int>(p.x / 78) * 4 + static_cast<int>(p.y / 94)];
  }
  EXPECT_EQ(in_cell.size(), 32u);
  for (const auto& [cell, count] : in_cell) EXPECT_GT(count, 3500 / 32 / 3) << cell;
}

TEST(ExtractFeatures, FlatTinyAndWrongImages) {
  const auto flat = Value(ExtractFeatures(cv::Mat(90, 120, CV_8U, cv::Scalar(77))));
  EXPECT_EQ(flat.size(), 0);
  for (const int side : {1, 2, 7, 16, 40}) {
    EXPECT_TRUE(ExtractFeatures(TexturedImage(side, side, 3)).ok()) << side;
    EXPECT_TRUE(ExtractFeatures(TexturedImage(300, side, 3)).ok()) << side;
  }
  EXPECT_FALSE(ExtractFeatures(cv::Mat()).ok());
  EXPECT_FALSE(ExtractFeatures(cv::Mat(20, 20, CV_8UC3)).ok());
}

// Of two pictures, the second 7 pixels to the right and 5 down, both kinds are found again.
TEST(ExtractFeatures, PlacesAreFoundAgain) {
  const cv::Mat image = TexturedImage(407, 305, 4);
  const auto first = Value(ExtractFeatures(image(cv::Rect(0, 0, 400, 300))));
  const auto second = Value(ExtractFeatures(image(cv::Rect(7, 5, 400, 300))));
  int key_points = 0, corners = 0, right = 0;
  for (const cv::DMatch& match : MatchFeatures(first, second)) {
    (match.queryIdx < first.key_point_count ? key_points : corners) += 1;
    const cv::Point2f moved = first.positions[match.queryIdx] - second.positions[match.trainIdx];
    right += cv::norm(moved - cv::Point2f(7, 5)) < 1.0;
  }
  EXPECT_GT(key_points, first.key_point_count / 2);
  EXPECT_GT(corners, (first.size() - first.key_point_count) / 2);
  EXPECT_GT(right, 0.95 * (key_points + corners));
}

// `count` features at random places; those of the second set are noisy copies in another order.
struct Sets {
  FeatureSet first, second;
  std::vector<int> truth;  // index in second of each of first
};

Sets MakeSets(int count, int key_points, int noise) {
  std::mt19937_64 engine(3);
  Sets sets;
  for (int i = 0; i < count; ++i) sets.truth.push_back(i);
  // Kinds stay together.
  std::shuffle(sets.truth.begin(), sets.truth.begin() + key_points, engine);
  std::shuffle(sets.truth.begin() + key_points, sets.truth.end(), engine);
  for (FeatureSet* set : {&sets.first, &sets.second}) {
    set->positions.resize(count);
    set->descriptors.create(count, 128, CV_32F);
    set->key_point_count = key_points;
  }
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 128; ++k) {
      const int value = static_cast<int>(engine() % 200);
      const int other = value + static_cast<int>(engine() % (2 * noise + 1)) - noise;
      sets.first.descriptors.at<float>(i, k) = static_cast<float>(value);
      sets.second.descriptors.at<float>(sets.truth[i], k) =
          static_cast<float>(std::clamp(other, 0, 255));
    }
  }
  return sets;
}

TEST(MatchFeatures, FindsNoisyCopies) {
  const Sets sets = MakeSets(400, 250, 20);
  const auto matches = MatchFeatures(sets.first, sets.second);
  ASSERT_EQ(matches.size(), 400u);
  for (int i = 0; i < 400; ++i) {
    EXPECT_EQ(matches[i].queryIdx, i);
    EXPECT_EQ(matches[i].trainIdx, sets.truth[i]);
  }
}

TEST(MatchFeatures, KindsAreMatchedApartAndSetsMayBeEmpty) {
  Sets sets = MakeSets(10, 10, 5);
  EXPECT_TRUE(MatchFeatures({}, sets.second).empty());
  EXPECT_TRUE(MatchFeatures(sets.first, {}).empty());
  sets.second.key_point_count = 0;
  EXPECT_TRUE(MatchFeatures(sets.first, sets.second).empty());
}

FeatureSet KeyPointsAt(const std::vector<float>& values) {
  FeatureSet set;
  set.key_point_count = static_cast<int64_t>(values.size());
  set.positions.resize(values.size());
  set.descriptors = cv::Mat::zeros(static_cast<int>(values.size()), 128, CV_32F);
  for (size_t i = 0; i < values.size(); ++i) {
    set.descriptors.at<float>(static_cast<int>(i), 0) = values[i];
  }
  return set;
}

TEST(MatchFeatures, TheNearestIsMutualAndClearlyNearerThanTheSecond) {
  EXPECT_EQ(MatchFeatures(KeyPointsAt({100}), KeyPointsAt({107, 90})).size(), 1u);
  EXPECT_EQ(MatchFeatures(KeyPointsAt({100}), KeyPointsAt({109, 90})).size(), 0u);
  EXPECT_EQ(MatchFeatures(KeyPointsAt({100}), KeyPointsAt({150})).size(), 1u) << "no second";
  EXPECT_EQ(MatchFeatures(KeyPointsAt({100}), KeyPointsAt({100, 100})).size(), 0u);
  // Of two with the same nearest the nearer has it.
  const auto matches = MatchFeatures(KeyPointsAt({90, 105}), KeyPointsAt({100, 200}));
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].queryIdx, 1);
}

TEST(MatchFeatures, SameForAnyNumberOfThreads) {
  const Sets sets = MakeSets(1500, 900, 90);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto one = MatchFeatures(sets.first, sets.second);
  cv::setNumThreads(4);
  const auto four = MatchFeatures(sets.first, sets.second);
  cv::setNumThreads(threads);
  ASSERT_EQ(one.size(), four.size());
  EXPECT_GT(one.size(), 1000u);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].queryIdx, four[i].queryIdx);
    EXPECT_EQ(one[i].trainIdx, four[i].trainIdx);
  }
}

TEST(AgreesWithNeighbours, KeepsWorldAndMoverAndDropsFalseMatches) {
  const std::vector<PointPair> pairs = {
      {1, 1, 2, 2},   {-1, -1, 0, 0}, {9, 9, 12, 10},     // the world
      {20, 5, 60, 5}, {25, 5, 62, 6}, {20, 9, 61, 12},    // a mover in front of it
      {42, 1, 43, 2},                                     // near one of the world alone
      {5, 5, 25, 5},  {NAN, 1, 2, 2}, {1e300, 1, 2, 2}};  // of no motion
  EXPECT_EQ(AgreesWithNeighbours(pairs), std::vector<uint8_t>({1, 1, 1, 1, 1, 1, 0, 0, 0, 0}));
  EXPECT_EQ(AgreesWithNeighbours({pairs[0], pairs[1]}), std::vector<uint8_t>({0, 0}));
  EXPECT_TRUE(AgreesWithNeighbours({}).empty());
}

}  // namespace
}  // namespace egosieve::vision
