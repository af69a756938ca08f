#include "tools/cli/progress.h"

#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

TEST(Progress, JsonIsAnObjectForEveryFrame) {
  std::ostringstream stream;
  {
    Progress progress("segment", ProgressMode::kJson, 3, stream, true);
    progress.Advance({{"model size", 12.0}});
    progress.Advance({{"model size", 13.0}});
  }
  std::istringstream lines(stream.str());
  std::string line;
  int64_t done = 0;
  while (std::getline(lines, line)) {
    const auto json = nlohmann::json::parse(line);
    EXPECT_EQ(json["command"], "segment");
    EXPECT_EQ(json["done"], ++done);
    EXPECT_EQ(json["total"], 3);
    EXPECT_EQ(json["model_size"], 11.0 + static_cast<double>(done));
    EXPECT_GE(json["eta_seconds"].get<double>(), 0.0);
  }
  EXPECT_EQ(done, 2);
}

TEST(Progress, ATerminalHasABarThatEndsWithALineBreak) {
  std::ostringstream stream;
  Progress progress("segment", ProgressMode::kAuto, 4, stream, true);
  for (int i = 0; i < 4; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(110));
    EXPECT_TRUE(progress.AdvanceUninterrupted());
  }
  progress.Finish();
  progress.Finish();
  EXPECT_THAT(stream.str(), HasSubstr("[######..................] segment: 1/4 frames"));
  EXPECT_THAT(stream.str(), HasSubstr("[########################] segment: 4/4 frames"));
  EXPECT_THAT(stream.str(), HasSubstr(" to go"));
  EXPECT_THAT(stream.str(), EndsWith("\n"));
  EXPECT_THAT(stream.str(), testing::Not(EndsWith("\n\n")));
}

TEST(Progress, IsSilentWhereItShouldBe) {
  std::ostringstream none, quick;
  Progress silent("segment", ProgressMode::kNone, 4, none, true);
  silent.Advance();
  silent.Finish();
  EXPECT_EQ(none.str(), "");
  Progress line("segment", ProgressMode::kAuto, 4, quick, false);  // done before a line is due
  line.Advance();
  line.Finish();
  EXPECT_EQ(quick.str(), "");
}

TEST(Progress, DoesNotTrustTheTotal) {
  std::ostringstream stream;
  Progress progress("segment", ProgressMode::kJson, 1, stream, false);
  progress.Advance();
  progress.Advance();
  EXPECT_THAT(stream.str(), HasSubstr("\"done\":2,\"total\":1"));
  EXPECT_THAT(stream.str(), HasSubstr("\"eta_seconds\":0"));
}

TEST(Progress, CountsInItsUnit) {
  std::ostringstream stream;
  Progress progress("evaluate", ProgressMode::kAuto, 2, stream, true, "sequence");
  std::this_thread::sleep_for(std::chrono::milliseconds(110));
  progress.Advance();
  EXPECT_THAT(stream.str(), HasSubstr("evaluate: 1/2 sequences, "));
  EXPECT_THAT(stream.str(), HasSubstr(" sequences/s, "));
}

TEST(Progress, TheTimeBeforeTheFirstIsNoRate) {
  EXPECT_EQ(RateOf(1, 10.0, 10.0), 0.1);
  EXPECT_EQ(RateOf(5, 12.0, 10.0), 2.0);
  EXPECT_EQ(RateOf(2, 10.0, 10.0), 0.2);
  EXPECT_EQ(RateOf(0, 0.0, 0.0), 0.0);
}

TEST(DescribeDuration, ReadsWell) {
  EXPECT_EQ(DescribeDuration(0.2), "0 s");
  EXPECT_EQ(DescribeDuration(59.4), "59 s");
  EXPECT_EQ(DescribeDuration(185.0), "3 min 05 s");
  EXPECT_EQ(DescribeDuration(2 * 3600.0 + 7 * 60.0), "2 h 07 min");
}

}  // namespace
}  // namespace egosieve::tools
