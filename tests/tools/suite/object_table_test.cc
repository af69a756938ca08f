#include "tools/suite/object_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace egosieve::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::IsEmpty;

// One frame of 40 x 10 pixels: two cars of 100 pixels, ahead (id 1) and oncoming (id 2); `called`
// columns of the image are called dynamic.
SequenceResult Result(const std::string& variant, int first, int called) {
  static const std::map<int, SyntheticObject> objects = {
      {1, {1, "car", "ahead", true, 10.0, 100}}, {2, {2, "car", "oncoming", true, 50.0, 100}}};
  ScoredFrame frame;
  frame.truth = cv::Mat1b::zeros(10, 60);
  frame.probability = cv::Mat1w::zeros(10, 60);
  frame.ids = cv::Mat1i::zeros(10, 60);
  frame.truth.colRange(0, 10) = 255;
  frame.ids.colRange(0, 10) = 1;
  frame.truth.colRange(20, 30) = 255;
  frame.ids.colRange(20, 30) = 2;
  frame.probability.colRange(first, first + called) = 65535;
  frame.objects = &objects;
  SequenceResult result;
  result.sequence = {"a", "a", "", ""};
  result.profile = variant;
  RunEvaluation run{{}, DriveScores({})};
  EXPECT_TRUE(run.scores.Add(frame).ok());
  MaskFrame numbered;
  numbered.truth = frame.truth;
  numbered.truth_ids = frame.ids;
  numbered.mask = cv::Mat1b::zeros(10, 60);
  numbered.mask.colRange(0, 4) = 255;  // two fifths of the first car
  numbered.mask.colRange(20, 26) = 255;
  numbered.mask.convertTo(numbered.ids, CV_32S);
  numbered.ids.colRange(20, 26) = 7;
  numbered.objects = &objects;
  EXPECT_TRUE(run.masks.Add(numbered).ok());
  result.run = std::move(run);
  return result;
}

TEST(ObjectTable, TellsRecallByGroupAndFalseObjectsByVariant) {
  const std::string table =
      ObjectTable({Result("all", 0, 10), Result("line", 45, 10), Result("all", 20, 10)});
  EXPECT_THAT(table, ContainsRegex("movers in maps.* objects +all +line\n"));
  EXPECT_THAT(table, ContainsRegex("\nrelation ahead +2 +0.500 0.500 +0.000 0.000\n"));
  EXPECT_THAT(table, ContainsRegex("\nahead within 40 m +2 +0.500 0.500 +0.000 0.000\n"));
  EXPECT_THAT(table, ContainsRegex("\nrelation oncoming +2 +0.500 0.500 +0.000 0.000\n"));
  EXPECT_THAT(table, ContainsRegex("\nfalse objects per frame +0.000 +1.000\n"));
  const std::string masks = table.substr(table.find("movers in masks"));
  EXPECT_THAT(masks, ContainsRegex("\nrelation ahead +2 +1.000 0.000 +1.000 0.000\n"));
  EXPECT_THAT(masks, ContainsRegex("\nrelation oncoming +2 +1.000 1.000 +1.000 1.000\n"));
  EXPECT_THAT(masks, ContainsRegex("\nfalse objects per frame +0.000 +0.000\n"));
}

TEST(ObjectTable, SaysNothingWhereObjectsAreNotToldApart) {
  SequenceResult failed;
  failed.profile = "all";
  EXPECT_THAT(ObjectTable({failed}), IsEmpty());
  EXPECT_THAT(ObjectTable({}), IsEmpty());
}

}  // namespace
}  // namespace egosieve::tools
