#include "tools/plots/plot_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/tools/testing/fresh_folder.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

PlotPage Page() {
  PlotPage page;
  page.title = "A & B";
  page.paragraphs = {"1 < 2"};
  Figure curve{"curve", "A curve", "What <it> shows.", "x", "y"};
  curve.series = {{"one", {0.0, 1.0, 2.0}, {0.0, std::nan(""), 1.0}},
                  {"two", {0.0, 1.0}, {1.0, 0.5}, {}, {}, Series::Style::kDashed}};
  Figure bars{"bars", "Bars", "Bars.", "", "y"};
  bars.categories = {"left", "right"};
  bars.series = {{"one", {0.0, 1.0}, {0.5, 1.0}, {}, {}, Series::Style::kBars}};
  Figure intervals{"intervals", "Intervals", "Intervals.", "", "y"};
  intervals.categories = {"left"};
  intervals.series = {{"one", {0.0}, {0.5}, {0.25}, {0.75}, Series::Style::kIntervals}};
  Figure empty{"empty", "Nothing", "Nothing.", "x", "y"};
  empty.series = {{"none", {0.0}, {std::nan("")}}};
  page.figures = {curve, bars, intervals, empty};
  return page;
}

TEST(WritePlotPage, DrawsEveryFigureThatHasPoints) {
  const std::string folder = FreshFolder();
  const absl::Status status = WritePlotPage(folder, Page());
  if (absl::IsFailedPrecondition(status)) GTEST_SKIP() << status.message();
  ASSERT_TRUE(status.ok()) << status;
  for (const char* id : {"curve", "bars", "intervals"}) {
    EXPECT_THAT(*ReadFile(folder + "/" + id + ".svg"), HasSubstr("</svg>")) << id;
    EXPECT_EQ(ReadFile(folder + "/" + id + ".png")->substr(1, 3), "PNG") << id;
  }
  EXPECT_FALSE(std::filesystem::exists(folder + "/empty.svg"));
  const std::string html = *ReadFile(folder + "/index.html");
  EXPECT_THAT(html, HasSubstr("<h1>A &amp; B</h1>"));
  EXPECT_THAT(html, HasSubstr("What &lt;it&gt; shows."));
  EXPECT_THAT(html, Not(HasSubstr("<?xml")));
  EXPECT_FALSE(std::filesystem::exists(folder + "/plot.log"));
}

TEST(WritePlotPage, WithoutALibraryTheDataAreThereAndItIsSaid) {
  const std::string folder = FreshFolder();
  const absl::Status missing = WritePlotPage(folder, Page(), "/no/such/python3");
  EXPECT_EQ(missing.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(missing.message()), HasSubstr("apt-get install python3-matplotlib"));
  const std::string data = *ReadFile(folder + "/figures.json");
  EXPECT_THAT(data, HasSubstr("\"curve\""));
  EXPECT_THAT(data, Not(HasSubstr("\"empty\"")));
  // A program that ends as plot.py does without its library.
  const absl::Status library = WritePlotPage(folder, Page(), "/bin/false");
  EXPECT_EQ(library.code(), absl::StatusCode::kUnavailable);
}

TEST(Figure, NaNBecomesNull) {
  const nlohmann::ordered_json json = ToJson(Page().figures);
  EXPECT_TRUE(json[0].at("series")[0].at("y")[1].is_null());
  EXPECT_EQ(json[0].at("series")[0].at("y")[2], 1.0);
}

}  // namespace
}  // namespace egosieve::tools
