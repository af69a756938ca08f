#include "tools/lab/compare/comparison_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/lab/compare/made_comparison.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

TEST(SummariseComparison, FiguresMatchHandWorkedOnes) {
  const std::vector<DriveComparison> drives = {
      MakeDrive("a", {0.5, 0.6, 0.7, 0.8, 0.9, 1.0}, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}),
      MakeDrive("b", {0.9, 0.9}, {0.4, 0.4})};
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
  // Drives weigh the same, however long they are.
  EXPECT_NEAR(summary.methods[1].difference_over_drives->mean, (0.25 + 0.5) / 2.0, 1e-12);
  EXPECT_EQ(summary.methods[1].difference_over_drives->frames, 2);
}

TEST(SummariseComparison, TellsTheFiguresWithoutTheLocationPriorBeside) {
  std::vector<DriveComparison> drives = {MakeDrive("a", {0.9, 0.9}, {0.8, 0.8})};
  for (MethodFrame& frame : drives[0].methods[0].frames) frame.auc_without_prior = 0.7;
  for (MethodFrame& frame : drives[0].methods[1].frames) frame.auc_without_prior = 0.75;
  const ComparisonSummary summary = Summarise(drives, {});
  EXPECT_NEAR(*summary.methods[0].drive_auc, 0.9, 1e-12);
  EXPECT_NEAR(*summary.methods[0].drive_auc_without_prior, 0.7, 1e-12);
  EXPECT_NEAR(summary.methods[1].difference_over_drives->mean, 0.1, 1e-12);
  EXPECT_NEAR(summary.methods[1].difference_over_drives_without_prior->mean, -0.05, 1e-12);
  EXPECT_THAT(ToTable(drives, summary), HasSubstr("the same without the location prior"));
}

TEST(SummariseComparison, EachDrivesIouWeighsTheSame) {
  std::vector<DriveComparison> drives = {MakeDrive("a", {0.9, 0.9, 0.9}, {0.8, 0.8, 0.8}),
                                         MakeDrive("b", {0.9}, {0.8})};
  const std::vector<std::vector<double>> first = {{0.6, 0.8, 0.7}, {0.1}},
                                         second = {{0.5, 0.5, 0.5}, {0.2}};
  for (size_t d = 0; d < drives.size(); ++d) {
    for (size_t i = 0; i < first[d].size(); ++i) {
      drives[d].methods[0].frames[i].iou = first[d][i];
      drives[d].methods[1].frames[i].iou = second[d][i];
    }
  }
  const ComparisonSummary summary = Summarise(drives, {});
  EXPECT_NEAR(*summary.methods[0].drive_iou, (0.7 + 0.1) / 2.0, 1e-12);
  EXPECT_NEAR(*summary.methods[1].drive_iou, (0.5 + 0.2) / 2.0, 1e-12);
  EXPECT_NEAR(summary.methods[1].iou_difference_over_drives->mean, (0.2 - 0.1) / 2.0, 1e-12);
  EXPECT_EQ(summary.methods[1].iou_difference_over_drives->frames, 2);
  EXPECT_THAT(ToTable(drives, summary), HasSubstr("mean IoU over frames with movers"));
}

TEST(SummariseComparison, AFailedDriveIsToldAndLeftOut) {
  DriveComparison failed;
  failed.sequence = {"c", "", "", ""};
  failed.status = absl::DataLossError("its masks are another drive's");
  std::vector<DriveComparison> drives = {MakeDrive("a", {0.5, 0.6, 0.7}, {0.5, 0.6, 0.7}), failed};
  const ComparisonSummary summary = Summarise(drives, {});
  EXPECT_EQ(summary.drives, 1);
  EXPECT_EQ(summary.failed, 1);
  EXPECT_THAT(ToTable(drives, summary), HasSubstr("failed: c: its masks are another drive's"));
  EXPECT_EQ(ToJson(drives, summary).at("drives")[1].at("error"), "its masks are another drive's");
  std::string csv;
  AppendCsv("p,", drives, &csv);
  EXPECT_THAT(csv, HasSubstr("p,a,svm,2,0.700000,20,7.000,100.000\n"));
  drives.front().sequence.name = "a,b";
  AppendCsv("p,", drives, &csv);
  EXPECT_THAT(csv, HasSubstr("p,\"a,b\",svm,2,0.700000,20,7.000,100.000\n"));
}

}  // namespace
}  // namespace egosieve::tools
