#include "tools/evaluation/objects.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::tools {
namespace {

cv::Mat1i Ids() { return cv::Mat1i::zeros(40, 60); }
cv::Mat1b Called() { return cv::Mat1b::zeros(40, 60); }

TEST(ObjectsTest, ExactPredictionFindsEveryObject) {
  cv::Mat1i ids = Ids();
  ids(cv::Rect(5, 5, 6, 4)) = 3;
  ids(cv::Rect(30, 20, 5, 5)) = 7;
  const cv::Mat1b called = ids != 0;
  const ObjectScores scores = *ScoreObjects(ComponentsOf(called), ids, {}, {});
  ASSERT_EQ(scores.objects.size(), 2u);
  EXPECT_EQ(scores.objects[0].id, 3);
  EXPECT_EQ(scores.objects[0].area, 24);
  EXPECT_EQ(scores.objects[0].iou, 1.0);
  EXPECT_TRUE(scores.objects[1].found);
  EXPECT_EQ(scores.false_objects, 0);
}

TEST(ObjectsTest, IouByHandAndItsThreshold) {
  cv::Mat1i ids = Ids();
  ids(cv::Rect(10, 10, 10, 10)) = 1;
  cv::Mat1b called = Called();
  called(cv::Rect(10, 10, 10, 5)) = 255;  // half of it
  called(cv::Rect(20, 10, 5, 4)) = 255;   // 20 pixels beside it
  ObjectOptions options;
  options.iou_threshold = 50.0 / 120.0;
  EXPECT_EQ(ScoreObjects(ComponentsOf(called), ids, {}, options)->objects[0].iou, 50.0 / 120.0);
  EXPECT_TRUE(ScoreObjects(ComponentsOf(called), ids, {}, options)->objects[0].found);
  options.iou_threshold = 0.42;
  EXPECT_FALSE(ScoreObjects(ComponentsOf(called), ids, {}, options)->objects[0].found);
}

TEST(ObjectsTest, OneComponentOverTwoNeighboursIsSharedBetweenThem) {
  cv::Mat1i ids = Ids();
  ids(cv::Rect(10, 10, 10, 10)) = 1;
  ids(cv::Rect(24, 10, 10, 10)) = 2;
  cv::Mat1b called = Called();
  called(cv::Rect(10, 10, 24, 10)) = 255;  // both, and the gap of 4 columns
  const ObjectScores scores = *ScoreObjects(ComponentsOf(called), ids, {}, {});
  EXPECT_EQ(scores.objects[0].iou, 100.0 / 120.0);  // two columns of the gap each
  EXPECT_EQ(scores.objects[1].iou, 100.0 / 120.0);
}

TEST(ObjectsTest, WhatCoversNothingIsAFalseObject) {
  cv::Mat1i ids = Ids();
  ids(cv::Rect(10, 10, 10, 10)) = 1;
  cv::Mat1b called = Called();
  called(cv::Rect(40, 10, 3, 3)) = 255;  // false
  called(cv::Rect(50, 30, 1, 3)) = 255;  // below min_area
  called(cv::Rect(5, 18, 6, 20)) = 255;  // 2 of 120 pixels on the object: false as well
  ObjectScores scores = *ScoreObjects(ComponentsOf(called), ids, {}, {});
  EXPECT_EQ(scores.false_objects, 2);
  EXPECT_FALSE(scores.objects[0].found);
  cv::Mat1b void_pixels = Called();
  void_pixels(cv::Rect(38, 8, 8, 8)) = 255;
  EXPECT_EQ(ScoreObjects(ComponentsOf(called), ids, void_pixels, {})->false_objects, 1);
}

TEST(ObjectsTest, SmallObjectsAreNotCounted) {
  cv::Mat1i ids = Ids();
  ids(cv::Rect(10, 10, 3, 1)) = 9;
  EXPECT_TRUE(ScoreObjects(ComponentsOf(Called()), ids, {}, {})->objects.empty());
  EXPECT_TRUE(ScoreObjects(ComponentsOf(Called()), Ids(), {}, {})->objects.empty());
}

TEST(ObjectsTest, WrongRequestsAreRefused) {
  EXPECT_EQ(ScoreObjects(ComponentsOf(Called()), cv::Mat1i::zeros(3, 3), {}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  ObjectOptions options;
  options.iou_threshold = 0.0;
  EXPECT_EQ(ScoreObjects(ComponentsOf(Called()), Ids(), {}, options).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(ObjectsTest, ComponentsTouchAtCorners) {
  cv::Mat1b mask = Called();
  mask(5, 5) = mask(6, 6) = mask(6, 9) = 255;
  const cv::Mat1i ids = ComponentsOf(mask);
  EXPECT_EQ(ids(5, 5), ids(6, 6));
  EXPECT_NE(ids(5, 5), ids(6, 9));
  EXPECT_EQ(ids(0, 0), 0);
}

}  // namespace
}  // namespace egosieve::tools
