#include <cmath>
#include <filesystem>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/run_command.h"
#include "tools/report/chart.h"
#include "tools/report/page.h"
#include "tools/report/report_command.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::vector<FrameLine> Lines(int64_t count) {
  std::vector<FrameLine> lines(count);
  for (int64_t i = 0; i < count; ++i) {
    lines[i].index = i;
    lines[i].model_size = 2 * i;
    lines[i].outcome = FrameLine::Outcome::kLearnt;
    lines[i].theta = {1.0, std::nan(""), 3.0};
    lines[i].milliseconds = {{"decode", 1.0}, {"features", 2.0}};
  }
  return lines;
}

const Chart* Find(const std::vector<Chart>& charts, const std::string& id) {
  for (const Chart& chart : charts) {
    if (chart.id == id) return &chart;
  }
  return nullptr;
}

TEST(MakeCharts, EveryFrameIsAPointUntilThereAreTooMany) {
  const std::vector<Chart> few = MakeCharts(Lines(10), std::nullopt, 10);
  ASSERT_NE(Find(few, "modelsize"), nullptr);
  EXPECT_EQ(Find(few, "modelsize")->values[0][7], 14.0);
  EXPECT_EQ(Find(few, "auc"), nullptr);
  EXPECT_EQ(Find(few, "likelihood"), nullptr);  // no frame trained

  const std::vector<Chart> many = MakeCharts(Lines(14500), std::nullopt, 1500);
  const Chart& size = *Find(many, "modelsize");
  EXPECT_EQ(size.x.size(), 1450u);
  EXPECT_EQ(size.x[1], 10.0);
  EXPECT_EQ(size.values[0][1], 2 * 14.5);  // the mean of 20, 22, ..., 38
  EXPECT_THAT(size.caption, HasSubstr("mean of 10 frames"));
  const Chart& stages = *Find(many, "stages");
  EXPECT_TRUE(stages.stacked);
  EXPECT_EQ(stages.series, (std::vector<std::string>{"decode", "features"}));
  const Chart& theta = *Find(many, "theta");
  EXPECT_TRUE(std::isnan(theta.values[1][0]));
  EXPECT_TRUE(ToJson(theta)["values"][1][0].is_null() ||
              std::isnan(ToJson(theta)["values"][1][0].get<double>()));
}

TEST(DescribeRanges, JoinsNeighbours) {
  EXPECT_EQ(DescribeRanges({}), "");
  EXPECT_EQ(DescribeRanges({4}), "4");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10}), "0-2, 7, 9-10");
}

TEST(MakeReportPage, EscapesWhatComesFromOutside) {
  ReportContent content;
  content.description.input.path = "/a/<script>alert(1)</script>.mp4";
  content.lines = Lines(3);
  content.lines[1].outcome = FrameLine::Outcome::kAnswered;
  content.lines[1].reason = "<b>7 & 8</b>";
  content.lines[2].milliseconds = {{"</script><b>", 1.0}};
  const std::string page = MakeReportPage(content);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;7 &amp; 8&lt;/b&gt;"));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
  EXPECT_THAT(page, HasSubstr("Dygraph"));
}

TEST(MakeReportPage, IsSelfContained) {
  ReportContent content;
  content.lines = Lines(3);
  const std::string page = MakeReportPage(content);
  EXPECT_THAT(page, Not(HasSubstr("<link")));
  EXPECT_THAT(page, Not(HasSubstr(" src=\"http")));
  EXPECT_THAT(page, Not(HasSubstr("url(http")));
}

TEST(MakeReportPage, AnEmptyRunHasAPageToo) {
  EXPECT_THAT(MakeReportPage(ReportContent()), HasSubstr("No frame was answered"));
}

TEST(ReportCommand, HasPicturesWhileTheInputIsThere) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/report");
  EXPECT_EQ(RunCommandForTest(MakeReportCommand(), {run.folder.path(), "--pictures=3"}).code, 0);
  const std::string page = *ReadFile(run.folder.File("report.html"));
  size_t pictures = 0;
  for (size_t at = page.find("data:image/jpeg"); at != std::string::npos;
       at = page.find("data:image/jpeg", at + 1)) {
    ++pictures;
  }
  EXPECT_EQ(pictures, 3u);
  EXPECT_THAT(page, HasSubstr("7 matches; 8 are needed"));

  std::filesystem::remove_all(run.frames);
  EXPECT_EQ(RunCommandForTest(MakeReportCommand(), {run.folder.path()}).code, 0);
  EXPECT_THAT(*ReadFile(run.folder.File("report.html")), HasSubstr("No pictures: "));
}

}  // namespace
}  // namespace egosieve::tools
