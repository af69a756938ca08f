#include "tools/suite/suite_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

// One frame of 100 pixels whose first `movers` move, with IoU `found / movers` at every threshold.
SequenceResult Result(const std::string& group, const std::string& name, int movers, int found) {
  ScoredFrame frame;
  frame.truth = cv::Mat1b::zeros(10, 10);
  frame.probability = cv::Mat1w::zeros(10, 10);
  for (int i = 0; i < movers; ++i) frame.truth(i / 10, i % 10) = 255;
  for (int i = 0; i < found; ++i) frame.probability(i / 10, i % 10) = 65535;
  SequenceResult result;
  result.sequence = {group + "/" + name, group, "", ""};
  result.profile = "default";
  RunEvaluation run{{}, DriveScores({})};
  EXPECT_TRUE(run.scores.Add(frame).ok());
  Summarise(run.scores, &run.evaluation);
  run.evaluation.truth_kind = "masks";
  result.run = std::move(run);
  return result;
}

size_t IndexOf(const std::string& name) {
  for (size_t i = 0; i < SuiteFigures().size(); ++i) {
    if (SuiteFigures()[i].name == name) return i;
  }
  ADD_FAILURE() << name;
  return 0;
}

TEST(SpreadOf, MatchesHandWorkedValues) {
  const auto spread = SpreadOf({1.0, 2.0, 6.0});
  ASSERT_TRUE(spread.has_value());
  EXPECT_DOUBLE_EQ(spread->mean, 3.0);
  EXPECT_DOUBLE_EQ(*spread->deviation, std::sqrt((4.0 + 1.0 + 9.0) / 2.0));
  EXPECT_EQ(spread->least, 1.0);
  EXPECT_EQ(spread->most, 6.0);
  EXPECT_FALSE(SpreadOf({5.0})->deviation.has_value());
  EXPECT_FALSE(SpreadOf({}).has_value());
}

TEST(SummariseSuite, MeansAreOverSequencesByGroupAndOverAll) {
  std::vector<SequenceResult> results = {Result("a", "one", 10, 10), Result("a", "two", 10, 5),
                                         Result("b", "three", 10, 2)};
  SequenceResult failed;
  failed.sequence = {"b/four", "b", "", ""};
  failed.profile = "default";
  failed.status = absl::NotFoundError("it is not there");
  results.push_back(failed);
  const SuiteSummary summary = SummariseSuite(results);
  EXPECT_EQ(summary.failed, 1);
  const size_t iou = IndexOf("mean_iou");
  EXPECT_DOUBLE_EQ(summary.figures.at({"a", "default"})[iou]->mean, 0.75);
  EXPECT_EQ(summary.figures.at({"b", "default"})[iou]->count, 1);  // the failed one has none
  EXPECT_NEAR(summary.figures.at({"all", "default"})[iou]->mean, (1.0 + 0.5 + 0.2) / 3.0, 1e-15);
  EXPECT_NEAR(summary.iou_by_threshold.at({"all", "default"})[9], (1.0 + 0.5 + 0.2) / 3.0, 1e-15);

  const std::string table = ToTable({}, results, summary);
  EXPECT_THAT(table, HasSubstr("failed: b/four, default: it is not there"));
  EXPECT_THAT(table, HasSubstr("3 of 4 runs scored, 1 failed"));
  const nlohmann::ordered_json json = ToJson({}, results, summary);
  EXPECT_EQ(json.at("sequences").size(), 4u);
  EXPECT_EQ(json.at("sequences")[3].at("error"), "it is not there");
  EXPECT_TRUE(json.at("sequences")[3].at("mean_auc").is_null());
  EXPECT_THAT(ToCsv(results), HasSubstr("b/four,b,default,0,NOT_FOUND,,"));
  results.back().sequence = {"b,c/\"four\"", "b,c", "", ""};
  EXPECT_THAT(ToCsv(results), HasSubstr("\"b,c/\"\"four\"\"\",\"b,c\",default,0,NOT_FOUND,,"));
}

TEST(ToMarkdown, MeanAndLeastOverAllSequencesOfAFolder) {
  SequenceResult tracks = Result("b", "three", 10, 10);
  tracks.run->evaluation.truth_kind = "tracks";
  SequenceResult failed;
  failed.sequence = {"b/four", "b", "", ""};
  failed.profile = "default";
  failed.status = absl::NotFoundError("it is not there");
  const std::string table =
      ToMarkdown({Result("a", "one", 10, 10), Result("a", "two", 10, 5), tracks, failed});
  // Five of ten movers above all static pixels, five level with them: (5 + 5 / 2) / 10.
  EXPECT_THAT(table, HasSubstr("| a | default | 2 of 2 | 0.875 | 0.750 | 0.750 | 0.500 |\n"));
  EXPECT_THAT(table, HasSubstr("| all | default | 3 of 4 | 0.917 | 0.750 | 0.750 | 0.500 |\n"));
  EXPECT_THAT(table, HasSubstr("| b | default | 1 of 2 | 1.000 | 1.000 | - | - |\n"));
}

TEST(SummariseSuite, TracksHaveNoShareInTheOneThreshold) {
  SequenceResult tracks = Result("a", "one", 10, 10);
  tracks.run->evaluation.truth_kind = "tracks";
  EXPECT_TRUE(SummariseSuite({tracks}).iou_by_threshold.empty());
}

}  // namespace
}  // namespace egosieve::tools
