#include "tools/evaluation/uncertainty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace egosieve::tools {
namespace {

constexpr int kHalf = 32768;

// The area under the remaining mean error as pixels leave one by one in the given order, each
// over an interval of 1/n, by 200 steps of the midpoint rule.
double AreaByMarching(const std::vector<double>& errors) {
  const double n = static_cast<double>(errors.size());
  double remaining = std::accumulate(errors.begin(), errors.end(), 0.0), area = 0.0;
  for (size_t i = 0; i < errors.size(); ++i) {
    constexpr int kSteps = 200;
    for (int k = 0; k < kSteps; ++k) {
      const double part = (k + 0.5) / kSteps;
      area += (remaining - part * errors[i]) / (n - static_cast<double>(i) - part) / (n * kSteps);
    }
    remaining -= errors[i];
  }
  return area;
}

TEST(UncertaintyTest, SparsificationEqualsTakingPixelsAwayOneByOne) {
  std::mt19937_64 random(5);
  struct Pixel {
    uint16_t score, deviation;
    bool positive;
    double Error() const { return positive ? 65535.0 - score : score; }
  };
  std::vector<Pixel> pixels;
  UncertaintyHistogram histogram(kHalf), first(kHalf), second(kHalf);
  std::vector<uint16_t> deviations(200);
  std::iota(deviations.begin(), deviations.end(), 100);  // distinct: the order is unique
  std::shuffle(deviations.begin(), deviations.end(), random);
  for (int i = 0; i < 200; ++i) {
    const Pixel p = {static_cast<uint16_t>(random()), deviations[i], random() % 2 == 0};
    pixels.push_back(p);
    histogram.Add(p.score, p.deviation, p.positive);
    (i % 3 == 0 ? first : second).Add(p.score, p.deviation, p.positive);
  }
  std::vector<double> ranked, oracle;
  std::sort(pixels.begin(), pixels.end(),
            [](const Pixel& a, const Pixel& b) { return a.deviation > b.deviation; });
  for (const Pixel& p : pixels) ranked.push_back(p.Error());
  oracle = ranked;
  std::sort(oracle.rbegin(), oracle.rend());
  const double mean = std::accumulate(ranked.begin(), ranked.end(), 0.0) / 200.0;
  const double expected = (AreaByMarching(ranked) - AreaByMarching(oracle)) / mean;
  // The midpoint rule's error is below h^2/24 max|f''|, largest for the last pixels: 1e-6 at most.
  EXPECT_NEAR(*histogram.AreaUnderSparsificationError(), expected, 1e-5);
  first.Merge(second);
  EXPECT_EQ(*first.AreaUnderSparsificationError(), *histogram.AreaUnderSparsificationError());
  EXPECT_EQ(*first.ErrorAuc(), *histogram.ErrorAuc());
}

TEST(UncertaintyTest, CurveByHand) {
  UncertaintyHistogram histogram(kHalf);
  histogram.Add(40000, 30, false);  // error 40000, wrong, most uncertain but one
  histogram.Add(10000, 40, false);  // 10000
  histogram.Add(65535, 20, true);   // 0
  histogram.Add(45535, 10, true);   // 20000
  const std::vector<SparsificationPoint> curve = histogram.Curve(4);
  const double all = 70000.0 / 4;
  EXPECT_NEAR(curve[0].remaining, 1.0, 1e-15);
  EXPECT_NEAR(curve[1].remaining, 60000.0 / 3 / all, 1e-15);
  EXPECT_NEAR(curve[2].remaining, 20000.0 / 2 / all, 1e-15);
  EXPECT_NEAR(curve[3].remaining, 20000.0 / all, 1e-15);
  EXPECT_NEAR(curve[1].oracle, 30000.0 / 3 / all, 1e-15);
  EXPECT_NEAR(curve[2].oracle, 10000.0 / 2 / all, 1e-15);
  EXPECT_NEAR(curve[3].oracle, 0.0, 1e-15);
  // The wrong pixel's deviation is beaten by one of three right ones.
  EXPECT_EQ(*histogram.ErrorAuc(), 2.0 / 3.0);
}

TEST(UncertaintyTest, PerfectRankingHasNoSparsificationErrorAndUselessOneHasMore) {
  UncertaintyHistogram perfect(kHalf), inverted(kHalf);
  for (int i = 0; i < 100; ++i) {
    const auto score = static_cast<uint16_t>(300 * i);
    perfect.Add(score, static_cast<uint16_t>(10 * i), false);
    inverted.Add(score, static_cast<uint16_t>(10 * (100 - i)), false);
  }
  EXPECT_NEAR(*perfect.AreaUnderSparsificationError(), 0.0, 1e-12);
  EXPECT_GT(*inverted.AreaUnderSparsificationError(), 0.5);
}

TEST(UncertaintyTest, NoFigureFromNothing) {
  UncertaintyHistogram histogram(kHalf);
  EXPECT_FALSE(histogram.AreaUnderSparsificationError().has_value());
  histogram.Add(0, 5, false);  // no error anywhere
  EXPECT_FALSE(histogram.AreaUnderSparsificationError().has_value());
  EXPECT_FALSE(histogram.ErrorAuc().has_value());
  EXPECT_TRUE(histogram.Curve(5).empty());
}

}  // namespace
}  // namespace egosieve::tools
