#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"
#include "tools/report/page.h"

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

// The contents of a page, as page.js gets them.
nlohmann::ordered_json ContentsOf(const std::string& page) {
  const std::string begin = "id=\"report\">";
  const size_t at = page.find(begin) + begin.size();
  return nlohmann::ordered_json::parse(page.substr(at, page.find("</script>", at) - at));
}

TEST(ColumnsOf, EveryFrameIsAPointUntilThereAreTooMany) {
  const auto few = ColumnsOf(Lines(10), 10);
  EXPECT_EQ(few["columns"]["/model_size"][7], 14.0);
  EXPECT_FALSE(few["columns"].contains("/log_likelihood_per_point"));  // no frame trained

  const auto many = ColumnsOf(Lines(14500), 1500);
  EXPECT_EQ(many["step"], 10);
  EXPECT_EQ(many["index"].size(), 1450u);
  EXPECT_EQ(many["index"][1], 10);
  const auto& columns = many["columns"];
  EXPECT_EQ(columns["/model_size"][1], 2 * 14.5);  // the mean of 20, 22, ..., 38
  EXPECT_EQ(columns["/milliseconds/features"][0], 2.0);
  EXPECT_EQ(columns["/theta/0"][0], 1.0);
  EXPECT_FALSE(columns.contains("/theta/1"));
}

TEST(ColumnsOf, TellWhereInTheDriveNothingWasLearnt) {
  std::vector<FrameLine> lines = Lines(14500);
  for (int i = 500; i < 1015; ++i) lines[i].outcome = FrameLine::Outcome::kAnswered;
  lines[1015].outcome = FrameLine::Outcome::kFailed;
  const auto columns = ColumnsOf(lines, 1450)["columns"];
  const auto at = [&](int point) {
    return std::vector<double>{columns["/outcome/learnt from"][point],
                               columns["/outcome/not learnt from"][point],
                               columns["/outcome/failed"][point]};
  };
  EXPECT_EQ(at(49), (std::vector<double>{1.0, 0.0, 0.0}));
  EXPECT_EQ(at(50), (std::vector<double>{0.0, 1.0, 0.0}));
  EXPECT_EQ(at(101), (std::vector<double>{0.4, 0.5, 0.1}));
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
  ReportContent content{.lines = Lines(5)};
  content.lines[1].map_device = content.lines[3].map_device = "another <device>";
  const std::string page = MakeReportPage(content);
  EXPECT_EQ(ContentsOf(page)["about"][2][0], "maps made on another <device>: 2");
}

TEST(MakeReportPage, TellsEveryStayOfAMover) {
  ReportContent content{.lines = Lines(5)};
  content.lines[0].doubt = "no frame before this one";
  content.tracks =
      "frame,time_seconds,id,left,top,width,height,area,probability,sure\n"
      "1,0.1,7,3,0,9,9,30,0.9,0.5\n2,0.2,7,3,0,9,9,30,0.9,0.5\n"
      "4,0.4,7,3,0,9,9,30,0.9,0.5\n4,0.4,12,3,0,9,9,30,0.9,0.5\n";
  const auto sections = ContentsOf(MakeReportPage(content))["sections"];
  EXPECT_EQ(sections[0]["title"], "What is doubtful");
  const auto timeline = sections[1]["timeline"];
  EXPECT_EQ(timeline["doubtful"].dump(), "[[0,0]]");
  EXPECT_EQ(timeline["rows"][0]["number"], 7);
  EXPECT_EQ(timeline["rows"][0]["stays"].dump(), "[[1,2],[4,4]]");
  EXPECT_EQ(timeline["rows"][1]["number"], 12);
  EXPECT_EQ(timeline["rows"][1]["stays"].dump(), "[[4,4]]");
  content.tracks = "frame,time_seconds,id\n";
  EXPECT_TRUE(ContentsOf(MakeReportPage(content))["sections"][1]["timeline"].is_null());
}

TEST(MakeReportPage, OpensWithTheVerdictAndTheDoubtfulStretches) {
  ReportContent content{.lines = Lines(12)};
  for (FrameLine& line : content.lines) {
    line.index *= 3;  // --skip=2
    line.time_seconds = 0.1 * line.index;
  }
  EXPECT_EQ(ContentsOf(MakeReportPage(content))["verdict"].back().dump(),
            R"(["Doubtful","no frame",""])");
  for (const int i : {2, 3, 4, 8}) content.lines[i].doubt = "dark";
  content.lines[3].doubt = content.lines[4].doubt = "7 of 9 places";
  content.tracks = "3,0.3,7,3,0,9,9,30,0.9,0.5\n";
  const auto contents = ContentsOf(MakeReportPage(content));
  EXPECT_EQ(contents["verdict"][0][1], "1 mover, in 1 of 12 frames: number 7 from 0.3 to 0.3 s");
  EXPECT_EQ(contents["verdict"][2].dump(),
            R"(["Doubtful","4 of 12 frames are unreliable, most often: 7 of 9 places","warning"])");
  const auto rows = contents["sections"][0]["table"]["rows"];
  EXPECT_EQ(rows[0].dump(), R"(["0.6 to 1.2","6 to 12",3,"7 of 9 places"])");
  EXPECT_EQ(rows[1].dump(), R"(["2.4 to 2.4","24 to 24",1,"dark"])");
}

TEST(DescribeRanges, JoinsNeighbours) {
  EXPECT_EQ(DescribeRanges({}), "");
  EXPECT_EQ(DescribeRanges({4}), "4");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10}), "0-2, 7, 9-10");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10, 12}, 2), "0-2, 9-10, and 2 more");
  EXPECT_EQ(DescribeRanges({0, 1, 2, 7, 9, 10, 12}, 4), "0-2, 7, 9-10, 12");
}

TEST(MakeReportPage, GroupsReasonsThatDifferInNumbersAlone) {
  ReportContent content{.lines = Lines(14500)};
  for (int i = 100; i < 3100; ++i) {
    content.lines[i].outcome = FrameLine::Outcome::kAnswered;
    content.lines[i].reason = absl::StrCat("only ", i, " of ", 2 * i, " features have a match");
  }
  content.lines[50].outcome = FrameLine::Outcome::kFailed;
  content.lines[50].reason = "torn";
  const auto rows = ContentsOf(MakeReportPage(content))["sections"][1]["table"]["rows"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].dump(), R"(["only 100 of 200 features have a match",3000,"100-3099"])");
  EXPECT_EQ(rows[1].dump(), R"(["failed: torn",1,"50"])");
}

// Ten frames of 1 ms and one of 100: what is usual and what is not must both be told.
TEST(MakeReportPage, TellsUsualAndSlowestTimes) {
  ReportContent content{.lines = Lines(11)};
  for (FrameLine& line : content.lines) line.milliseconds = {{"decode", 1.0}};
  content.lines[5].milliseconds = {{"decode", 100.0}};
  EXPECT_EQ(ContentsOf(MakeReportPage(content))["sections"][2]["table"]["rows"][0].dump(),
            R"(["decode","1.0","1.0","100.0","100.0 %"])");
}

TEST(ColumnsOf, AFrameWithoutAMapHasNoDynamicShare) {
  std::vector<FrameLine> lines = Lines(3);
  for (FrameLine& line : lines) line.model_size = 5;
  lines[0].width_pixels = lines[0].height_pixels = 100;
  const auto share = ColumnsOf(lines, 100)["columns"]["/dynamic_share"];
  EXPECT_TRUE(share[0].is_number());
  EXPECT_TRUE(share[1].is_null());
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
  EXPECT_THAT(page, Not(HasSubstr("<b>7")));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
  EXPECT_THAT(page, HasSubstr("Dygraph"));
  const auto contents = ContentsOf(page);
  EXPECT_EQ(contents["sections"][0]["table"]["rows"][0][3], "<i>9 & 10</i>");
  EXPECT_EQ(contents["sections"][1]["table"]["rows"][0][0], "<b>7 & 8</b>");
}

TEST(MakeReportPage, IsSelfContained) {
  const std::string page = MakeReportPage({.lines = Lines(3)});
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
