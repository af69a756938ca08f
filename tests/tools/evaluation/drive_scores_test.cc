#include "tools/evaluation/drive_scores.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <string>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

constexpr uint16_t kHigh = 60000, kLow = 5000;

// A mover of 10 x 10 pixels at (10, 10), called exactly; deviation large where `noisy` says.
ScoredFrame Frame(int64_t index) {
  ScoredFrame frame;
  frame.index = index;
  frame.truth = cv::Mat1b::zeros(40, 60);
  frame.truth(cv::Rect(10, 10, 10, 10)) = 255;
  frame.probability = cv::Mat1w(40, 60, kLow);
  frame.probability(cv::Rect(10, 10, 10, 10)) = kHigh;
  frame.deviation = cv::Mat1w(40, 60, uint16_t{100});
  return frame;
}

TEST(DriveScoresTest, ExactMapHasExactFigures) {
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(Frame(3)).ok());
  const nlohmann::ordered_json json = scores.ToJson();
  EXPECT_EQ(json.at("pooled_auc"), 1.0);
  EXPECT_EQ(json.at("average_precision"), 1.0);
  EXPECT_EQ(json.at("at_declared_threshold").at("iou"), 1.0);
  EXPECT_EQ(json.at("mean_boundary_f"), 1.0);
  EXPECT_EQ(json.at("object_recall").at("all").at("recall"), 1.0);
  EXPECT_EQ(json.at("false_objects_per_frame"), 0.0);
  EXPECT_TRUE(json.at("false_positive_rate_without_movers").is_null());
  EXPECT_TRUE(json.at("uncertainty").at("error_auc").is_null());  // nothing is wrong
  EXPECT_EQ(scores.frames()[0].index, 3);
}

TEST(DriveScoresTest, FramesWithoutMoversHaveAFalsePositiveRateAndNothingElse) {
  ScoredFrame empty = Frame(0);
  empty.truth.setTo(0);
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(empty).ok());
  EXPECT_FALSE(scores.frames()[0].auc.has_value());
  EXPECT_FALSE(scores.frames()[0].iou.has_value());
  EXPECT_EQ(*scores.FalsePositiveRateWithoutMovers(), 100.0 / 2400.0);
  EXPECT_EQ(scores.objects().FalseObjectsPerFrame(), 1.0);
  EXPECT_TRUE(scores.ToJson().at("pooled_auc").is_null());
  EXPECT_TRUE(scores.ToJson().at("mean_iou").is_null());
  EXPECT_TRUE(scores.ToJson().at("at_best_threshold").is_null());
}

TEST(DriveScoresTest, FiguresOfAFrameAndTheirMeans) {
  ScoredFrame half = Frame(1);  // the mover's lower half is missed: IoU 1/2, F 2/3
  half.probability(cv::Rect(10, 15, 10, 5)) = kLow;
  ScoredFrame none = Frame(2);
  none.truth.setTo(0);
  DriveScores scores({});
  for (const ScoredFrame& frame : {Frame(0), half, none}) ASSERT_TRUE(scores.Add(frame).ok());
  const FrameScores& middle = scores.frames()[1];
  EXPECT_EQ(middle.dynamic_pixels, 100);
  EXPECT_EQ(middle.static_pixels, 2300);
  EXPECT_EQ(middle.iou, 0.5);
  EXPECT_NEAR(*middle.f, 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(*middle.best_iou, 0.5, 1e-15);
  // Half above all negatives; the rest at a precision of 100 / 2400.
  EXPECT_NEAR(*middle.average_precision, 0.5 + 0.5 * 100.0 / 2400.0, 1e-15);
  EXPECT_EQ(scores.Mean(&FrameScores::iou), 0.75);
  // kLow is 0.076 and kHigh 0.916 of full: at 0.05 everything is called, at 0.95 nothing.
  const std::vector<double> by_threshold = scores.MeanIouByThreshold();
  EXPECT_NEAR(by_threshold.front(), 100.0 / 2400.0, 1e-15);
  EXPECT_EQ(by_threshold[9], 0.75);
  EXPECT_EQ(by_threshold.back(), 0.0);
}

// Of 2,400 pixels the 10 that are wrong have p = 0.6 and all others 0.08 or 0.92: the class is in
// doubt where the map errs, which the deviation, the same everywhere, cannot tell.
TEST(DriveScoresTest, DoubtOfTheClassFindsErrorsNearTheThreshold) {
  ScoredFrame frame = Frame(0);
  frame.probability(cv::Rect(30, 30, 10, 1)) = 39321;
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(frame).ok());
  EXPECT_EQ(scores.class_uncertainty().ErrorAuc(), 1.0);
  EXPECT_EQ(scores.uncertainty().ErrorAuc(), 0.5);
}

TEST(DriveScoresTest, ScatteredPointsHaveNoOutlinesAndNoObjects) {
  ScoredFrame points = Frame(0);
  points.scattered = true;
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(points).ok());
  EXPECT_EQ(scores.frames()[0].iou, 1.0);
  EXPECT_FALSE(scores.frames()[0].boundary_f.has_value());
  EXPECT_TRUE(scores.objects().recall().empty());
  EXPECT_FALSE(scores.objects().FalseObjectsPerFrame().has_value());
}

TEST(DriveScoresTest, NoFigureFromNothing) {
  const nlohmann::ordered_json json = DriveScores({}).ToJson();
  EXPECT_TRUE(json.at("pooled_auc").is_null());
  EXPECT_TRUE(json.at("calibration").is_null());
  EXPECT_TRUE(json.at("uncertainty").is_null());
  EXPECT_TRUE(json.at("object_recall").empty());
}

TEST(DriveScoresTest, VoidPixelsAreNowhere) {
  ScoredFrame frame = Frame(0);
  frame.probability(cv::Rect(40, 10, 8, 8)) = kHigh;  // false, but void
  frame.truth(cv::Rect(38, 8, 12, 12)) = 128;
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(frame).ok());
  EXPECT_EQ(scores.pooled().negative_count(), 2400 - 100 - 144);
  EXPECT_EQ(scores.ToJson().at("at_declared_threshold").at("iou"), 1.0);
  EXPECT_EQ(scores.objects().FalseObjectsPerFrame(), 0.0);
}

// A mover half of which is only likely, and a likely patch of the static world.
TEST(DriveScoresTest, ObjectsAreSureSomewhere) {
  ScoredFrame frame = Frame(0);
  frame.probability(cv::Rect(10, 15, 10, 5)) = ThresholdOf(0.3);
  frame.probability(cv::Rect(40, 10, 8, 8)) = ThresholdOf(0.8) - 1;
  DriveScoresOptions options;
  options.objects.thresholds = {0.3, 0.7};
  DriveScores scores({}), likely(options);
  ASSERT_TRUE(scores.Add(frame).ok());
  ASSERT_TRUE(likely.Add(frame).ok());
  EXPECT_EQ(scores.objects().recall().at("all").iou_sum, 1.0);
  EXPECT_EQ(scores.objects().FalseObjectsPerFrame(), 0.0);
  EXPECT_EQ(likely.objects().FalseObjectsPerFrame(), 1.0);
  EXPECT_EQ(scores.frames()[0].iou, 50.0 / 164.0);  // of pixels, at 0.5
}

TEST(DriveScoresTest, RecallByHeadingSizeAndDistance) {
  ScoredFrame frame = Frame(0);
  frame.truth(cv::Rect(30, 20, 5, 4)) = 255;  // missed
  frame.ids = cv::Mat1i::zeros(40, 60);
  frame.ids(cv::Rect(10, 10, 10, 10)) = 4;
  frame.ids(cv::Rect(30, 20, 5, 4)) = 9;
  frame.truth(cv::Rect(50, 20, 5, 4)) = 255;
  frame.ids(cv::Rect(50, 20, 5, 4)) = 11;
  const std::map<int, SyntheticObject> objects = {
      {4, {4, "car", "ahead", true, 12.0, 2500}},
      {11, {11, "cyclist", "ahead", true, 15.0, 300}},
      {9, {9, "pedestrian", "crossing", true, 55.0, 80}}};
  frame.objects = &objects;
  DriveScores scores({});
  ASSERT_TRUE(scores.Add(frame).ok());
  ASSERT_TRUE(scores.Add(frame).ok());
  const auto& recall = scores.objects().recall();
  EXPECT_EQ(recall.at("all").objects, 6);
  EXPECT_EQ(recall.at("all").found, 2);
  EXPECT_EQ(recall.at("relation ahead").found_at_50, 2);
  EXPECT_EQ(recall.at("ahead within 40 m").objects, 4);
  EXPECT_EQ(recall.at("ahead vehicle within 40 m").objects, 2);
  EXPECT_EQ(recall.at("relation crossing").found_at_30, 0);
  EXPECT_EQ(recall.at("size under 100").objects, 2);
  EXPECT_EQ(recall.at("size from 1600").found, 2);
  EXPECT_EQ(recall.at("distance from 40 m").objects, 2);
  EXPECT_EQ(recall.count("crossing within 40 m"), 0u);
  EXPECT_THAT(scores.Summary(), HasSubstr("(from 0.25, with 0.80), relation ahead: 2 of 4 found"));
}

TEST(DriveScoresTest, MergedHalvesEqualTheWhole) {
  DriveScores whole({}), first({}), second({});
  for (int k = 0; k < 4; ++k) {
    ScoredFrame frame = Frame(k);
    cv::RNG random(k + 1);
    for (uint16_t& p : frame.probability)
      p = static_cast<uint16_t>(std::min(65535, p + random.uniform(0, 30000)));
    for (uint16_t& d : frame.deviation) d = static_cast<uint16_t>(random.uniform(0, 65536));
    ASSERT_TRUE(whole.Add(frame).ok());
    ASSERT_TRUE((k < 2 ? first : second).Add(frame).ok());
  }
  first.Merge(second);
  EXPECT_EQ(first.ToJson(), whole.ToJson());
}

TEST(DriveScoresTest, MapsOfAnotherSizeAreRefusedAndLeaveNothing) {
  ScoredFrame frame = Frame(7);
  frame.truth = cv::Mat1b::zeros(40, 61);
  DriveScores scores({});
  const absl::Status status = scores.Add(frame);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("frame 7"));
  EXPECT_TRUE(scores.frames().empty());
  EXPECT_EQ(scores.pooled().negative_count(), 0);
}

TEST(DriveScoresTest, OptionsAreChecked) {
  DriveScoresOptions options;
  options.threshold = std::nan("");
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  options = {};
  options.calibration_bins = 0;
  EXPECT_FALSE(options.Validate().ok());
  EXPECT_TRUE(DriveScoresOptions().Validate().ok());
}

}  // namespace
}  // namespace egosieve::tools
