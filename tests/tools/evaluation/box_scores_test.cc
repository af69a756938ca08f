#include "tools/evaluation/box_scores.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

LabelledBox Box(double left, double top, double right, double bottom, bool moving, double depth) {
  LabelledBox box;
  box.box_class = BoxClass::kVehicle;
  box.left = left;
  box.top = top;
  box.right = right;
  box.bottom = bottom;
  box.moving = moving;
  box.depth_metres = depth;
  return box;
}

// A 40 x 20 image at every pixel: 1 in the left half, 0 in the right.
class BoxScoresTest : public testing::Test {
 protected:
  BoxScoresTest() : map_(20, 40, 0.0f) { map_.colRange(0, 20).setTo(1.0f); }

  const kernels::ImageGrid grid_{40, 20, 1};
  cv::Mat1f map_;
};

// The box from 10 to 30 has its middle from 14 to 26: of the columns 14 .. 26 six are marked.
TEST_F(BoxScoresTest, TheMeanIsOverTheMiddleOfBothSides) {
  EXPECT_DOUBLE_EQ(MeanInMiddle(Box(10, 0, 30, 10, true, 5), map_, grid_, 0.6), 6.0 / 13.0);
  EXPECT_DOUBLE_EQ(MeanInMiddle(Box(10, 0, 30, 10, true, 5), map_, grid_, 1.0), 10.0 / 21.0);
  map_.row(5).setTo(0.0f);  // of the rows 2 .. 8
  EXPECT_DOUBLE_EQ(MeanInMiddle(Box(0, 0, 10, 10, true, 5), map_, grid_, 0.6), 6.0 / 7.0);
  EXPECT_LT(MeanInMiddle(Box(50, 0, 60, 10, true, 5), map_, grid_, 0.6), 0.0);
}

TEST_F(BoxScoresTest, BoxesAreCountedByKindAndDistance) {
  BoxScores scores;
  scores.Add({Box(0, 0, 10, 10, true, 5), Box(5, 0, 15, 10, true, 15), Box(28, 0, 38, 10, true, 15),
              Box(28, 5, 38, 15, false, 45)},
             map_, grid_);
  EXPECT_EQ(scores.Of("moving vehicle", "all").boxes, 3);
  EXPECT_EQ(scores.Of("moving vehicle", "all").marked, 2);
  EXPECT_EQ(scores.Of("moving vehicle", "10-20 m").boxes, 2);
  EXPECT_EQ(scores.Of("moving vehicle", "10-20 m").marked, 1);
  EXPECT_EQ(scores.Of("standing vehicle", "40+ m").boxes, 1);
  EXPECT_EQ(scores.Of("standing vehicle", "all").marked, 0);
  EXPECT_EQ(scores.Of("moving cyclist", "all").boxes, 0);
  EXPECT_THAT(scores.ToTable(), HasSubstr("2 of 3 0.67"));
  EXPECT_EQ(scores.ToJson()["kinds"]["moving vehicle"]["10-20 m"]["marked"], 1);
}

TEST_F(BoxScoresTest, HiddenAndUnknownBoxesAreLeftOut) {
  LabelledBox truncated = Box(0, 0, 10, 10, true, 5), occluded = truncated, unknown = truncated,
              untold = truncated, partly = truncated;
  truncated.truncated = 2;
  occluded.occluded = 2;
  unknown.moving.reset();
  untold.box_class = BoxClass::kUntold;
  partly.truncated = partly.occluded = 1;
  BoxScores scores;
  scores.Add({truncated, occluded, unknown, untold, partly}, map_, grid_);
  EXPECT_EQ(scores.left_out(), 4);
  EXPECT_EQ(scores.Of("moving vehicle", "all").boxes, 1);
}

// The box covers columns 0 .. 9 of all rows: 30 columns are outside, of which 10 are marked.
TEST_F(BoxScoresTest, WhatIsOutsideAllBoxesIsAShareOfTheArea) {
  BoxScores scores;
  scores.Add({Box(0, 0, 9, 19, true, 5)}, map_, grid_);
  EXPECT_DOUBLE_EQ(scores.OutsideShare(), 10.0 / 30.0);
  BoxScores other;
  other.Add({}, cv::Mat1f(20, 40, 0.0f), grid_);
  scores.Merge(other);
  EXPECT_EQ(scores.frames(), 2);
  EXPECT_DOUBLE_EQ(scores.OutsideShare(), 10.0 / 70.0);
}

TEST(BoxScoresOptions, ValidateNamesItsFields) {
  EXPECT_TRUE(BoxScoresOptions().Validate().ok());
  EXPECT_THAT(std::string(BoxScoresOptions{.middle = 0.0}.Validate().message()),
              HasSubstr("middle = 0"));
}

}  // namespace
}  // namespace egosieve::tools
