#include "tools/lab/compare/block_bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egosieve::tools {
namespace {

TEST(BlockBootstrap, AConstantDifferenceIsCertain) {
  const auto interval = BlockBootstrap({{0.5, 0.5, 0.5}, {}, {0.5}}, {});
  ASSERT_TRUE(interval.has_value());
  EXPECT_EQ(interval->frames, 4);
  EXPECT_DOUBLE_EQ(interval->mean, 0.5);
  EXPECT_NEAR(interval->low, 0.5, 1e-15);
  EXPECT_NEAR(interval->high, 0.5, 1e-15);
  EXPECT_EQ(interval->share_positive, 1.0);
  EXPECT_FALSE(BlockBootstrap({{}}, {}).has_value());
}

// Values of 0 and 1 in equal parts: the mean of n drawn has the binomial's deviation, 1 / (2
// sqrt(n)); of 100, 0.025 of the means lie below 0.40 and above 0.60.
TEST(SequenceBootstrap, DrawsWholeSequences) {
  std::vector<double> values(50, 0.0);
  values.resize(100, 1.0);
  const auto interval = SequenceBootstrap(values, {});
  ASSERT_TRUE(interval.has_value());
  EXPECT_EQ(interval->frames, 100);
  EXPECT_DOUBLE_EQ(interval->mean, 0.5);
  EXPECT_NEAR(interval->low, 0.40, 0.011);  // a mean is a multiple of 0.01
  EXPECT_NEAR(interval->high, 0.60, 0.011);
  EXPECT_FALSE(SequenceBootstrap({}, {}).has_value());
  const auto one = SequenceBootstrap({0.25}, {});
  EXPECT_EQ(one->low, 0.25);
  EXPECT_EQ(one->high, 0.25);
}

// Independent frames: the interval is that of a mean, +-1.96 sigma / sqrt(n). With 2,000 resamples
// a quantile's own error is about 4 % of it, and the sample's deviation is known to 1 / sqrt(2 n).
TEST(BlockBootstrap, IndependentFramesGiveTheNormalInterval) {
  std::mt19937_64 random(3);
  std::vector<double> values(900);
  double sum = 0.0, squares = 0.0;
  for (double& value : values) {
    value = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
    sum += value;
    squares += value * value;
  }
  const double deviation = std::sqrt(squares / 900.0);
  BootstrapOptions options;
  options.block_frames = 1;
  const auto interval = BlockBootstrap({values}, options);
  const double half = 1.96 * deviation / 30.0;
  EXPECT_NEAR(interval->high - interval->low, 2.0 * half, 0.25 * half);
  EXPECT_NEAR(interval->mean, sum / 900.0, 1e-12);
}

// Frames that come in runs of ten alike carry a tenth of the information: with blocks of ten the
// interval is sqrt(10) times as wide as with single frames.
TEST(BlockBootstrap, BlocksSeeThatNeighboursAreAlike) {
  std::mt19937_64 random(4);
  std::vector<double> values;
  for (int run = 0; run < 60; ++run) {
    const double value = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
    values.insert(values.end(), 10, value);
  }
  BootstrapOptions single, blocks;
  single.block_frames = 1;
  blocks.block_frames = 10;
  const auto narrow = BlockBootstrap({values}, single), wide = BlockBootstrap({values}, blocks);
  // Blocks that straddle two runs average them: their variance is about 2/3 of a run's.
  const double ratio = (wide->high - wide->low) / (narrow->high - narrow->low);
  EXPECT_GT(ratio, 2.0);
  EXPECT_LT(ratio, 3.5);
}

// A block as long as the drive would draw the whole drive each time, and be sure of its mean.
TEST(BlockBootstrap, AShortDriveIsNotCertain) {
  const auto interval = BlockBootstrap({{0.3, -0.1, 0.2, 0.4, 0.1, -0.2}}, {});
  EXPECT_NEAR(interval->mean, 0.7 / 6.0, 1e-15);
  EXPECT_LT(interval->low, interval->mean - 0.05);
  EXPECT_GT(interval->high, interval->mean + 0.05);
}

TEST(BlockBootstrap, IsTheSameForTheSameSeed) {
  const std::vector<std::vector<double>> drives = {{0.1, -0.9, 0.3, 0.05}, {0.2, 0.0}};
  const auto first = BlockBootstrap(drives, {}), second = BlockBootstrap(drives, {});
  EXPECT_EQ(first->low, second->low);
  EXPECT_EQ(first->high, second->high);
  BootstrapOptions single;
  single.block_frames = 1;
  BootstrapOptions other = single;
  other.seed = 2;
  EXPECT_NE(BlockBootstrap(drives, other)->share_positive,
            BlockBootstrap(drives, single)->share_positive);
}

std::vector<FrameFigure> Line(int count, double height, double slope) {
  std::vector<FrameFigure> frames;
  for (int i = 0; i < count; ++i) frames.push_back({2.0 * i, height + slope * 2.0 * i});
  return frames;
}

TEST(SlopeBootstrap, LinesAtDifferentHeightsHaveTheirCommonSlope) {
  const auto interval =
      SlopeBootstrap({Line(20, 0.2, 0.01), Line(7, 0.9, 0.01), Line(2, 0, 5)}, {});
  ASSERT_TRUE(interval.has_value());
  EXPECT_EQ(interval->frames, 27);  // two frames have no trend
  EXPECT_NEAR(interval->mean, 0.01, 1e-15);
  EXPECT_NEAR(interval->low, 0.01, 1e-12);
  EXPECT_NEAR(interval->high, 0.01, 1e-12);
  EXPECT_FALSE(SlopeBootstrap({{}, Line(2, 0, 1)}, {}).has_value());
  EXPECT_FALSE(SlopeBootstrap({{{4, 1}, {4, 2}, {4, 3}}}, {}).has_value());  // one instant
}

// By hand: frames 0, 1, 2, 4 with figures 1, 0, 2, 1; means 7/4 and 1; products sum to 1 and
// squares to 35/4.
TEST(SlopeBootstrap, TheSlopeIsThatOfLeastSquares) {
  const auto interval = SlopeBootstrap({{{0, 1}, {1, 0}, {2, 2}, {4, 1}}}, {});
  EXPECT_NEAR(interval->mean, 1.0 / 8.75, 1e-15);
}

// Independent errors of deviation s around a line over n frames: the slope's deviation is
// s / sqrt(n (n^2 - 1) / 12).
TEST(SlopeBootstrap, IndependentErrorsGiveTheNormalInterval) {
  std::mt19937_64 random(8);
  const int n = 300;
  std::vector<FrameFigure> frames;
  for (int i = 0; i < n; ++i) {
    const double error = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
    frames.push_back({static_cast<double>(i), 0.4 + 1e-4 * i + error});
  }
  BootstrapOptions single;
  single.block_frames = 1;
  const auto interval = SlopeBootstrap({frames}, single);
  const double deviation = std::sqrt(1.0 / 12.0) / std::sqrt(n * (n * n - 1.0) / 12.0);
  // A quantile of 2,000 resamples is known to about 4 %, the sample's deviation to 3 %.
  EXPECT_NEAR((interval->high - interval->low) / (2.0 * 1.96 * deviation), 1.0, 0.15);
  EXPECT_NEAR(interval->mean, 1e-4, 4.0 * deviation);
  EXPECT_EQ(SlopeBootstrap({frames}, single)->low, interval->low);
}

TEST(BootstrapOptions, AreChecked) {
  BootstrapOptions options;
  options.block_frames = 0;
  EXPECT_FALSE(options.Validate().ok());
  EXPECT_TRUE(BootstrapOptions().Validate().ok());
}

}  // namespace
}  // namespace egosieve::tools
