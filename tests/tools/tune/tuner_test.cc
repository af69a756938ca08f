#include "tools/tune/tuner.h"

#include <algorithm>
#include <limits>
#include <string>

#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::tune {
namespace {

TuneOptions SmallSearch() {
  TuneOptions options{
      .training_points = 60, .mean_queries = 200, .variance_queries = 100, .repeats = 1};
  // Every shape is compiled anew: a search over all fields takes a minute.
  options.fields = {"mean_width", "depth"};
  return options;
}

// The seconds of a line of `progress`: "depth 8: 1.234 ms (best 1.300)".
double Milliseconds(const std::string& line) { return std::stod(line.substr(line.find(": ") + 2)); }

// With a least gain of zero the time that is kept is the least of all that were taken.
TEST(Tune, KeepsTheFastestShape) {
  if (kernels::TestIsOnReference()) GTEST_SKIP() << "the reference has no shapes";
  TuneOptions options = SmallSearch();
  options.least_gain = 0.0;
  options.fields = {"mean_width"};
  double fastest = std::numeric_limits<double>::infinity();
  options.progress = [&](const std::string& line) {
    fastest = std::min(fastest, Milliseconds(line));
  };
  const auto result = Value(Tune(options));
  // Lines have three digits behind the point.
  EXPECT_NEAR(1e3 * result.mean_seconds_after, std::min(fastest, 1e3 * result.mean_seconds_before),
              5.1e-4);
  EXPECT_EQ(result.after == result.before, result.mean_seconds_after == result.mean_seconds_before);
}

// Nothing is a hundred times as fast.
TEST(Tune, ChangesNothingForLessThanTheLeastGain) {
  if (kernels::TestIsOnReference()) GTEST_SKIP() << "the reference has no shapes";
  TuneOptions options = SmallSearch();
  options.least_gain = 0.99;
  options.fields = {"mean_width"};
  const auto result = Value(Tune(options));
  EXPECT_EQ(result.after, result.before);
}

TEST(Tune, TimesEveryCandidateOfTheFields) {
  if (kernels::TestIsOnReference()) GTEST_SKIP() << "the reference has no shapes";
  TuneOptions options = SmallSearch();
  int lines = 0;
  options.progress = [&](const std::string& line) { lines += line.empty() ? 0 : 1; };
  const auto result = Value(Tune(options));
  EXPECT_TRUE(result.after.Validate().ok());
  EXPECT_EQ(result.shapes_timed, 3 + 5);  // all candidates but those that hold already
  EXPECT_EQ(result.after.panel, result.before.panel);
  EXPECT_EQ(result.shapes_dropped, 0);
  EXPECT_EQ(lines, result.shapes_timed);
  EXPECT_FALSE(result.device.empty());
}

TEST(Tune, SearchesTilesInLocalMemory) {
  if (kernels::TestIsOnReference()) GTEST_SKIP() << "the reference has no shapes";
  TuneOptions options = SmallSearch();
  options.begin = kernels::DefaultGpuTuning();
  options.begin->panel = 4;
  options.begin->panels_per_group = 4;
  options.begin->width = 2;
  options.begin->mean_width = 1;
  options.begin->work_group = 16;
  options.fields = {"depth"};
  const auto result = Value(Tune(options));
  EXPECT_EQ(result.before, *options.begin);
  EXPECT_EQ(result.after.local_tiles, 1);
  // 8; 16 holds already, and 32 does not divide the block of 16 rows.
  EXPECT_EQ(result.shapes_timed, 1);
  EXPECT_EQ(result.shapes_dropped, 0);
}

TEST(Tune, TheReferenceIsRefused) {
  TuneOptions options = SmallSearch();
  options.device = "reference";
  EXPECT_EQ(Tune(options).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(Tune, ADeviceThatIsNotThereIsNotFound) {
  TuneOptions options = SmallSearch();
  options.device = "no such device";
  EXPECT_EQ(Tune(options).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace egosieve::tune
