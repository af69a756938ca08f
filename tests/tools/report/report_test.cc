#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"
#include "tools/report/chart.h"
#include "tools/report/page.h"
#include "tools/report/timeline.h"

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

TEST(MakeCharts, TellWhereInTheDriveNothingWasLearnt) {
  std::vector<FrameLine> lines = Lines(14500);
  for (int i = 500; i < 1015; ++i) lines[i].outcome = FrameLine::Outcome::kAnswered;
  lines[1015].outcome = FrameLine::Outcome::kFailed;
  const std::vector<Chart> charts = MakeCharts(lines, std::nullopt, 1450);
  const Chart& outcome = *Find(charts, "outcome");
  EXPECT_TRUE(outcome.stacked);
  const auto at = [&](int point) {
    return std::vector<double>{outcome.values[0][point], outcome.values[1][point],
                               outcome.values[2][point]};
  };
  EXPECT_EQ(at(49), (std::vector<double>{100.0, 0.0, 0.0}));
  EXPECT_EQ(at(50), (std::vector<double>{0.0, 100.0, 0.0}));
  EXPECT_EQ(at(101), (std::vector<double>{40.0, 50.0, 10.0}));
}

TEST(MakeReportPage, TellsThatPicturesLieFarApart) {
  ReportContent content;
  content.description.flags["front_end"] = "default";
  content.lines = Lines(5);
  for (FrameLine& line : content.lines) line.features = line.matches = 100;
  EXPECT_THAT(MakeReportPage(content), Not(HasSubstr("too far apart")));
  for (int i = 1; i < 5; ++i) content.lines[i].matches = 10;
  EXPECT_THAT(MakeReportPage(content), HasSubstr("4 of 5 pairs of pictures lie too far apart"));
}

TEST(MakeReportPage, NamesOtherDevices) {
  ReportContent content;
  content.lines = Lines(5);
  content.lines[1].map_device = content.lines[3].map_device = "another <device>";
  const std::string page = MakeReportPage(content);
  EXPECT_THAT(page, HasSubstr("maps made on another &lt;device&gt;: 2<"));
}

TEST(MoverTimeline, HasABarForEveryStay) {
  std::vector<FrameLine> lines(5);
  for (int i = 0; i < 5; ++i) {
    lines[i].index = i;
    if (i == 0) lines[i].doubt = "no frame before this one";
  }
  const std::string svg = MoverTimeline(
      "frame,time_seconds,id,left,top,width,height,area,probability,sure\n"
      "1,0.1,7,3,0,9,9,30,0.9,0.5\n2,0.2,7,3,0,9,9,30,0.9,0.5\n"
      "4,0.4,7,3,0,9,9,30,0.9,0.5\n4,0.4,12,3,0,9,9,30,0.9,0.5\n",
      lines);
  EXPECT_THAT(svg, HasSubstr("7: frames 1 to 2"));
  EXPECT_THAT(svg, HasSubstr("7: frames 4 to 4"));
  EXPECT_THAT(svg, HasSubstr("12: frames 4 to 4"));
  EXPECT_THAT(svg, HasSubstr("#e3e6ea"));  // frame 0
  EXPECT_EQ(MoverTimeline("frame,time_seconds,id\n", lines), "");
}

TEST(DescribeRanges, JoinsNeighbours) {
  EXPECT_EQ(DescribeRanges({}), "");
  EXPECT_EQ(DescribeRanges({4}), "4");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10}), "0-2, 7, 9-10");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10, 12}, 2), "0-2, 9-10, and 2 more");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10, 12}, 4), "0-2, 7, 9-10, 12");
}

TEST(MakeReportPage, GroupsReasonsThatDifferInNumbersAlone) {
  ReportContent content;
  content.lines = Lines(14500);
  for (int i = 100; i < 3100; ++i) {
    content.lines[i].outcome = FrameLine::Outcome::kAnswered;
    content.lines[i].reason = absl::StrCat("only ", i, " of ", 2 * i, " features have a match");
  }
  content.lines[50].outcome = FrameLine::Outcome::kFailed;
  content.lines[50].reason = "torn";
  const std::string page = MakeReportPage(content);
  EXPECT_THAT(page, HasSubstr("only 100 of 200 features have a match</td><td class=\"number\">3000"
                              "</td><td>100-3099</td>"));
  EXPECT_THAT(page, Not(HasSubstr("only 101 of 202")));
  EXPECT_LT(page.find("only 100 of 200"), page.find("failed: torn"));
}

// Ten frames of 1 ms and one of 100: what is usual and what is not must both be told.
TEST(MakeReportPage, TellsUsualAndSlowestTimes) {
  ReportContent content;
  content.lines = Lines(11);
  for (FrameLine& line : content.lines) line.milliseconds = {{"decode", 1.0}};
  content.lines[5].milliseconds = {{"decode", 100.0}};
  EXPECT_THAT(MakeReportPage(content),
              HasSubstr("<td>decode</td><td class=\"number\">1.0</td><td class=\"number\">1.0</td>"
                        "<td class=\"number\">100.0</td><td class=\"number\">100.0 %</td>"));
}

TEST(MakeReportPage, AFrameWithoutAMapHasNoDynamicShare) {
  std::vector<FrameLine> lines = Lines(3);
  for (FrameLine& line : lines) line.model_size = 5;
  lines[0].width_pixels = lines[0].height_pixels = 100;
  const std::vector<Chart> charts = MakeCharts(lines, std::nullopt, 100);
  const Chart& share = *Find(charts, "share");
  EXPECT_TRUE(std::isfinite(share.values[0][0]));
  EXPECT_TRUE(std::isnan(share.values[0][1]));
}

TEST(MakeReportPage, EscapesWhatComesFromOutside) {
  ReportContent content;
  content.description.input.path = "/a/<script>alert(1)</script>.mp4";
  content.lines = Lines(3);
  content.lines[1].outcome = FrameLine::Outcome::kAnswered;
  content.lines[1].reason = "<b>7 & 8</b>";
  content.lines[2].doubt = "<i>9 & 10</i>";
  content.lines[2].milliseconds = {{"</script><b>", 1.0}};
  const std::string page = MakeReportPage(content);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;7 &amp; 8&lt;/b&gt;"));
  EXPECT_THAT(page, HasSubstr("1 of 3 frames are unreliable, most often: &lt;i&gt;9 &amp; 10"));
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
  EXPECT_THAT(RunCommandForTest(MakeReportCommand(), {run.folder.path(), "--pictures=3"}),
              Succeeds());
  const std::string page = *ReadFile(run.folder.File("report.html"));
  size_t pictures = 0;
  for (size_t at = page.find("data:image/jpeg"); at != std::string::npos;
       at = page.find("data:image/jpeg", at + 1)) {
    ++pictures;
  }
  EXPECT_EQ(pictures, 3u);
  EXPECT_THAT(page, HasSubstr("7 matches; 8 are needed"));

  // What cannot be read costs its part of the page, and no more.
  ASSERT_TRUE(WriteFileAtomically(run.folder.File("eval.json"), "{").ok());
  ASSERT_TRUE(WriteFileAtomically(run.folder.FrameFile("grid", 5, ".prob.png"), "torn").ok());
  EXPECT_THAT(RunCommandForTest(MakeReportCommand(), {run.folder.path(), "--pictures=3"}),
              Succeeds());
  EXPECT_THAT(*ReadFile(run.folder.File("report.html")), HasSubstr("pictures are missing: "));

  std::filesystem::remove_all(run.frames);
  EXPECT_THAT(RunCommandForTest(MakeReportCommand(), {run.folder.path()}), Succeeds());
  EXPECT_THAT(*ReadFile(run.folder.File("report.html")), HasSubstr("no pictures: "));
}

}  // namespace
}  // namespace egosieve::tools
