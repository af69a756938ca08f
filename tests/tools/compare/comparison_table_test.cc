#include "tools/compare/comparison_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/compare/comparison_figures.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

// Six frames in which the method has the AUC given: one mover against a hundred static pixels, of
// which the share `auc` lies below it.
MethodResult Method(const std::string& name, const std::vector<double>& aucs) {
  MethodResult method{name, true, DriveScores({}), {}};
  for (size_t i = 0; i < aucs.size(); ++i) {
    ScoredFrame frame;
    frame.index = static_cast<int64_t>(i);
    frame.scattered = true;
    frame.truth = cv::Mat1b::zeros(1, 101);
    frame.truth(0, 100) = 255;
    frame.probability = cv::Mat1w(1, 101, uint16_t{60000});
    for (int k = 0; k < std::lround(100 * aucs[i]); ++k) frame.probability(0, k) = 100;
    frame.probability(0, 100) = 30000;
    EXPECT_TRUE(method.scores.Add(frame).ok());
    method.frames.push_back({frame.index, method.scores.frames().back().auc,
                             static_cast<int64_t>(10 * i), 5.0 + static_cast<double>(i)});
  }
  return method;
}

DriveComparison Drive(const std::string& name, const std::vector<double>& first,
                      const std::vector<double>& second) {
  DriveComparison drive;
  drive.sequence.name = name;
  drive.frames = static_cast<int64_t>(first.size());
  drive.methods = {Method("arcsine", first), Method("svm", second)};
  drive.shared_milliseconds.assign(first.size(), 100.0);
  return drive;
}

TEST(SummariseComparison, FiguresMatchHandWorkedOnes) {
  const std::vector<DriveComparison> drives = {
      Drive("a", {0.5, 0.6, 0.7, 0.8, 0.9, 1.0}, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}),
      Drive("b", {0.9, 0.9}, {0.4, 0.4})};
  const ComparisonSummary summary = Summarise(drives, {});
  ASSERT_EQ(summary.methods.size(), 2u);
  const MethodSummary& arcsine = summary.methods[0];
  EXPECT_NEAR(*arcsine.frame_auc, (4.5 + 1.8) / 8.0, 1e-12);
  EXPECT_NEAR(*arcsine.drive_auc, (0.75 + 0.9) / 2.0, 1e-12);
  EXPECT_NEAR(*arcsine.gain, 0.95 - 0.55, 1e-12);  // drive b is too short to have one
  EXPECT_EQ(arcsine.model_size, (50.0 + 10.0) / 2.0);
  EXPECT_EQ(arcsine.scores.frames().size(), 8u);
  EXPECT_FALSE(arcsine.difference.has_value());
  EXPECT_NEAR(summary.methods[1].difference->mean, (1.5 + 1.0) / 8.0, 1e-12);
  EXPECT_EQ(summary.methods[1].difference->frames, 8);
  EXPECT_EQ(summary.shared_milliseconds, 100.0);
}

TEST(SummariseComparison, AFailedDriveIsToldAndLeftOut) {
  DriveComparison failed;
  failed.sequence = {"c", "", "", ""};
  failed.status = absl::DataLossError("its masks are another drive's");
  const std::vector<DriveComparison> drives = {Drive("a", {0.5, 0.6, 0.7}, {0.5, 0.6, 0.7}),
                                               failed};
  const ComparisonSummary summary = Summarise(drives, {});
  EXPECT_EQ(summary.drives, 1);
  EXPECT_EQ(summary.failed, 1);
  EXPECT_THAT(ToTable(drives, summary), HasSubstr("failed: c: its masks are another drive's"));
  EXPECT_EQ(ToJson(drives, summary).at("drives")[1].at("error"), "its masks are another drive's");
  EXPECT_THAT(ToCsv(drives), HasSubstr("a,svm,2,0.700000,20,7.000,100.000\n"));
}

TEST(CompareWithPaper, SaysWhatIsShownAndWhatIsNot) {
  const std::vector<DriveComparison> ahead = {
      Drive("a", {0.9, 0.9, 0.9, 0.9, 0.9, 0.8}, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5})};
  const std::vector<std::string> lines = CompareWithPaper(Summarise(ahead, {}));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[0], HasSubstr("arcsine ahead of svm: shown"));
  EXPECT_THAT(lines[1], HasSubstr("-0.050 (not shown)"));
  const std::vector<DriveComparison> behind = {Drive("a", {0.4, 0.4, 0.4}, {0.5, 0.5, 0.5})};
  EXPECT_THAT(CompareWithPaper(Summarise(behind, {}))[0], HasSubstr("contradicted"));
  const std::vector<DriveComparison> equal = {Drive("a", {0.4, 0.6, 0.5}, {0.6, 0.4, 0.5})};
  EXPECT_THAT(CompareWithPaper(Summarise(equal, {}))[0], HasSubstr("not decided"));
}

TEST(MakeComparisonPage, FiguresHoldTheCurves) {
  const std::vector<DriveComparison> drives = {
      Drive("a", {0.5, 0.6, 0.7, 0.8}, {0.5, 0.5, 0.5, 0.5})};
  const PlotPage page = MakeComparisonPage(drives, Summarise(drives, {}), "");
  for (const char* id : {"roc", "auc_by_frame", "model_size", "differences", "drives", "time"}) {
    bool found = false;
    for (const Figure& figure : page.figures) found |= figure.id == id && HasPoints(figure);
    EXPECT_TRUE(found) << id;
  }
}

}  // namespace
}  // namespace egosieve::tools
