#include "tools/lab/compare/profile_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/tools/lab/compare/made_comparison.h"
#include "tools/lab/compare/comparison_figures.h"

namespace egosieve::tools {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ProfileComparison MakeProfile(const std::string& name, std::vector<DriveComparison> drives) {
  ProfileComparison profile{name, {{"budget", "7"}}, std::move(drives), {}};
  profile.summary = Summarise(profile.drives, {});
  return profile;
}

std::vector<std::string> Claims(const DriveComparison& drive) {
  return CompareWithPaper(Summarise({drive}, {}));
}

TEST(CompareWithPaper, SaysWhichOrderIsShown) {
  const std::vector<double> half(6, 0.5);
  EXPECT_THAT(Claims(MakeDrive("a", std::vector<double>(6, 0.9), half))[0],
              HasSubstr("the paper's claim: arcsine ahead of svm: shown (AUC +0.400"));
  EXPECT_THAT(Claims(MakeDrive("a", std::vector<double>(6, 0.4), half))[0],
              HasSubstr("contradicted"));
  EXPECT_THAT(Claims(MakeDrive("a", {0.4, 0.6, 0.5}, {0.6, 0.4, 0.5}))[0], HasSubstr("not shown"));
  EXPECT_THAT(Claims(MakeDrive("a", half, half, "dense_optical_flow"))[0],
              HasSubstr("arcsine ahead of dense_optical_flow: not shown"));
}

TEST(CompareWithPaper, SaysWhetherAccuracyGrows) {
  const std::vector<double> rising = {0.5, 0.6, 0.7, 0.8}, falling = {0.8, 0.7, 0.6, 0.5};
  const std::vector<std::string> lines = Claims(MakeDrive("a", rising, falling));
  EXPECT_THAT(
      lines,
      testing::Contains(HasSubstr("arcsine improves over time: shown (AUC +10.000 in 100 frames")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("svm improves over time: contradicted")));
  // A drive that gets easier for what learns nothing as well proves nothing.
  EXPECT_THAT(Claims(MakeDrive("a", rising, rising, "labels")),
              testing::Contains(AllOf(HasSubstr("arcsine improves over time: not shown (lead over "
                                                "labels +0.000"),
                                      HasSubstr("; AUC +10.000)"))));
  EXPECT_THAT(Claims(MakeDrive("a", rising, falling, "labels")),
              testing::Contains(HasSubstr("shown (lead over labels +20.000 in 100 frames")));
}

TEST(CompareWithPaper, SaysWhetherTheLabelsAreAsAssumed) {
  DriveComparison drive = MakeDrive("a", {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5});
  for (const std::string& line : Claims(drive)) EXPECT_THAT(line, Not(HasSubstr("assumption")));
  drive.labels.features[0] = 1000;
  drive.labels.dynamic[0] = 30;
  drive.labels.features[1] = 15;
  drive.labels.dynamic[1] = 10;
  EXPECT_THAT(Claims(drive).back(),
              AllOf(HasSubstr("does not hold of the dynamic labels (25 % of 40 lie on movers)"),
                    HasSubstr("holds on movers (67 % of their 15 features")));
}

TEST(ProfileComparison, ColumnsStandSideBySide) {
  const std::vector<ProfileComparison> profiles = {
      MakeProfile("paper", {MakeDrive("a", {0.6, 0.7, 0.8}, {0.5, 0.5, 0.5})}),
      MakeProfile("default", {MakeDrive("a", {0.9, 0.9, 0.9}, {0.4, 0.4, 0.4})})};
  const std::string table = ToTable(profiles);
  EXPECT_THAT(table, AllOf(HasSubstr("arcsine                    0.7000   0.7000"),
                           HasSubstr("     0.9000   0.9000"), HasSubstr("profile paper\n"),
                           HasSubstr("profile default\n")));
  EXPECT_THAT(ToCsv(profiles), AllOf(HasSubstr("paper,a,svm,2,0.500000,20,7.000,100.000\n"),
                                     HasSubstr("default,a,arcsine,0,0.900000,")));
  const auto json = ToJson(profiles);
  ASSERT_EQ(json.at("profiles").size(), 2u);
  EXPECT_EQ(json.at("profiles")[1].at("profile"), "default");
  EXPECT_EQ(json.at("profiles")[1].at("flags").at("budget"), "7");
  EXPECT_NEAR(json.at("profiles")[0].at("methods")[0].at("auc_over_frames").get<double>(), 0.7,
              1e-12);
}

TEST(ProfileComparison, AProfileOfWhichEveryDriveFailedIsTold) {
  DriveComparison failed;
  failed.sequence.name = "a";
  failed.status = absl::DataLossError("no features");
  const std::vector<ProfileComparison> profiles = {
      MakeProfile("paper", {failed}),
      MakeProfile("default", {MakeDrive("a", {0.9, 0.9, 0.9}, {0.4, 0.4, 0.4})})};
  EXPECT_THAT(ToTable(profiles), AllOf(HasSubstr("arcsine                         -        -"),
                                       HasSubstr("failed: a: no features")));
  EXPECT_EQ(ToJson(profiles).at("profiles")[0].at("failed"), 1);
  for (const Figure& figure : MakeComparisonPage(profiles).figures) {
    EXPECT_THAT(figure.id, Not(HasSubstr("paper")));
  }
}

TEST(MakeComparisonPage, HasEveryFigureOnceAProfile) {
  const std::vector<DriveComparison> drives = {
      MakeDrive("a", {0.5, 0.6, 0.7, 0.8}, {0.5, 0.5, 0.5, 0.5})};
  const PlotPage one = MakeComparisonPage({MakeProfile("paper", drives)});
  const PlotPage two =
      MakeComparisonPage({MakeProfile("paper", drives), MakeProfile("no-road+x", drives)});
  std::set<std::string> ids_of_one, ids_of_two;
  for (const Figure& figure : one.figures) {
    if (HasPoints(figure)) ids_of_one.insert(figure.id);
  }
  for (const Figure& figure : two.figures) {
    if (HasPoints(figure)) ids_of_two.insert(figure.id);
  }
  for (const char* id :
       {"roc", "auc_by_frame", "trends", "model_size", "differences", "drives", "time"}) {
    EXPECT_EQ(ids_of_one.count(id), 1u) << id;
    EXPECT_EQ(ids_of_two.count(std::string(id) + "_paper"), 1u) << id;
    EXPECT_EQ(ids_of_two.count(std::string(id) + "_no_road_and_x"), 1u) << id;
  }
  EXPECT_EQ(ids_of_two.count("profiles"), 1u);
  EXPECT_EQ(ids_of_two.size(), 2 * ids_of_one.size() + 1);
}

}  // namespace
}  // namespace egosieve::tools
