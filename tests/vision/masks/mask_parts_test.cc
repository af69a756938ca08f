#include <functional>
#include <numeric>
#include <vector>

#include "gtest/gtest.h"
#include "vision/masks/glimpses.h"
#include "vision/masks/motion_split.h"
#include "vision/masks/mover_motion.h"
#include "vision/masks/moving_cells.h"

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

const cv::Size kSize(160, 80);
const cv::Rect kRegion(20, 20, 80, 40);

cv::Mat1b Mask() {
  cv::Mat1b mask = cv::Mat1b::zeros(kSize);
  mask(kRegion) = 255;
  return mask;
}

// The region's cells, all of which hold over one horizon.
MovingCells CellsOf(const std::function<cv::Point2f(cv::Point2f place)>& step) {
  MovingCells cells = FollowCells(Mask(), {});
  MovingCells::Horizon horizon;
  for (const cv::Point2f& place : cells.places) horizon.displacement.push_back(step(place));
  horizon.holds.assign(cells.places.size(), 1);
  cells.horizons = {horizon};
  return cells;
}

std::vector<int> AllOf(const MovingCells& cells) {
  std::vector<int> all(cells.places.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(FitMotion, FindsAnAffineMotionBesideAThirdOfOutliers) {
  std::vector<cv::Point2f> places, steps;
  for (int i = 0; i < 300; ++i) {
    const cv::Point2f p(static_cast<float>(i % 20) * 5.0f, static_cast<float>(i / 20) * 5.0f);
    places.push_back(p);
    steps.emplace_back(3.0f + 0.02f * p.x, -1.0f + 0.02f * p.y);
    if (i % 3 == 0) steps.back() += cv::Point2f(20.0f, 9.0f);
  }
  const MoverMotion motion = FitMotion(places, steps, 0.7);
  // The stiffness takes 49 / (49 + the places' variance, 470 or more) off the gradient: 0.1 of 0.02
  // times at most 50 pixels; outliers, 22 pixels away, weigh 1e-6.
  EXPECT_NEAR(motion.At({90, 60}).x, 4.8, 0.1);
  EXPECT_NEAR(motion.At({90, 60}).y, 0.2, 0.1);
  const cv::Point2d source = motion.Source({50, 40});
  const cv::Point2d back = source + motion.At(source);
  EXPECT_NEAR(back.x, 50.0, 1e-9);
  EXPECT_NEAR(back.y, 40.0, 1e-9);
  EXPECT_EQ(FitMotion({}, {}, 0.7).At({5, 5}), cv::Point2d());
}

TEST(FollowCells, AddsStepsUpAndStopsAtTheBorderAndWhereFlowDoesNotReturn) {
  FlowPair flow = {cv::Mat(kSize, CV_32FC2, cv::Scalar(15.0, 0.0)),
                   cv::Mat(kSize, CV_32FC2, cv::Scalar(-15.0, 0.0))};
  const MovingCells cells = FollowCells(Mask(), std::vector<FlowPair>(5, flow));
  ASSERT_EQ(cells.horizons.size(), 5u);
  EXPECT_EQ(cells.cells.size(), 20u * 10u);
  EXPECT_FLOAT_EQ(cells.horizons[0].displacement[0].x, 75.0f);
  for (size_t i = 0; i < cells.places.size(); ++i) {
    EXPECT_EQ(cells.horizons[0].holds[i] != 0, cells.places[i].x + 75.0f <= 159.0f) << i;
  }
  flow.backward.setTo(cv::Scalar(15.0, 0.0));
  const MovingCells lost = FollowCells(Mask(), {flow});
  EXPECT_EQ(std::accumulate(lost.horizons[0].holds.begin(), lost.horizons[0].holds.end(), 0), 0);
}

TEST(SplitByMotion, SeparatesASmallPartBeforeALargeOne) {
  const cv::Rect small(48, 20, 12, 40);
  const MovingCells cells = CellsOf([&](cv::Point2f p) {
    return small.contains(cv::Point(p)) ? cv::Point2f(-12.0f, 0.0f) : cv::Point2f(12.0f, 1.0f);
  });
  const auto split = SplitByMotion(cells, AllOf(cells));
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->smaller.size(), 3u * 10u);
  EXPECT_EQ(split->larger.size(), 17u * 10u);
  for (const int i : split->smaller) EXPECT_TRUE(small.contains(cv::Point(cells.places[i])));
}

TEST(SplitByMotion, CellsThatGetHiddenGoWithTheirMotionOverFewerFrames) {
  const cv::Rect small(48, 20, 12, 40);
  MovingCells cells = CellsOf([&](cv::Point2f p) {
    return small.contains(cv::Point(p)) ? cv::Point2f(-12.0f, 0.0f) : cv::Point2f(12.0f, 1.0f);
  });
  MovingCells::Horizon two = cells.horizons[0];
  for (size_t i = 0; i < cells.places.size(); ++i) {
    two.displacement[i] *= 2.0f;
    if (cells.places[i].x > 36.0f && cells.places[i].x < 48.0f) two.holds[i] = 0;
  }
  cells.horizons.insert(cells.horizons.begin(), two);
  const auto split = SplitByMotion(cells, AllOf(cells));
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->smaller.size(), 3u * 10u);
  EXPECT_EQ(split->larger.size(), 17u * 10u);
}

TEST(SplitByMotion, KeepsTogetherWhatZoomsAndWhatSwingsByLessThanItsSize) {
  const MovingCells zoom =
      CellsOf([](cv::Point2f p) { return 0.1f * (p - cv::Point2f(60.0f, 40.0f)); });
  EXPECT_FALSE(SplitByMotion(zoom, AllOf(zoom)).has_value());
  // A limb of 16 x 20 pixels, 17.9 in size, that moves 6 pixels against the body; 12.5 would part
  // it.
  const auto swinging = [](float pixels) {
    return CellsOf([pixels](cv::Point2f p) {
      return cv::Rect(20, 40, 16, 20).contains(cv::Point(p)) ? cv::Point2f(3.0f + pixels, 0.0f)
                                                             : cv::Point2f(3.0f, 0.0f);
    });
  };
  const MovingCells limb = swinging(6.0f), parting = swinging(20.0f);
  EXPECT_FALSE(SplitByMotion(limb, AllOf(limb)).has_value());
  EXPECT_TRUE(SplitByMotion(parting, AllOf(parting)).has_value());
}

TEST(MotionDistance, IsBelowOneForPartsOfOneMotion) {
  const MovingCells cells = CellsOf([](cv::Point2f p) {
    return p.x < 60.0f ? cv::Point2f(6.0f, 0.0f) : cv::Point2f(6.0f, 3.0f);
  });
  std::vector<int> left, near, right;
  for (size_t i = 0; i < cells.places.size(); ++i) {
    const float x = cells.places[i].x;
    (x < 40.0f ? left : x < 60.0f ? near : right).push_back(static_cast<int>(i));
  }
  EXPECT_NEAR(MotionDistance(cells, left, near, 0.0).value_or(9.0), 0.0, 1e-6);
  EXPECT_NEAR(MotionDistance(cells, left, right, 0.0).value_or(0.0), 3.0 / 1.5, 1e-5);
  EXPECT_LT(MotionDistance(cells, left, right, 0.4).value_or(9.0), 1.0);
  EXPECT_FALSE(MotionDistance(cells, {}, right, 0.4).has_value());
}

}  // namespace
}  // namespace egosieve::vision
