#include "tools/evaluation/roc.h"

#include <random>
#include <utility>

#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

TEST(RocHistogram, HandWorkedCases) {
  RocHistogram roc;
  EXPECT_FALSE(roc.Auc().has_value());
  roc.Add(100, true);
  EXPECT_FALSE(roc.Auc().has_value());
  roc.Add(50, false);
  EXPECT_EQ(*roc.Auc(), 1.0);
  roc.Add(65535, false);  // pairs: won, lost
  EXPECT_EQ(*roc.Auc(), 0.5);
  roc.Add(0, true);  // pairs: won, lost, lost, lost
  EXPECT_EQ(*roc.Auc(), 0.25);
  roc.Add(50, true);  // and: tied, lost
  EXPECT_EQ(*roc.Auc(), 1.5 / 6.0);
}

TEST(RocHistogram, EqualsTheCountOverAllPairs) {
  std::mt19937_64 random(3);
  std::vector<std::pair<uint16_t, bool>> samples;
  RocHistogram roc, first, second;
  for (int i = 0; i < 400; ++i) {
    const bool positive = random() % 3 == 0;
    const uint16_t score = static_cast<uint16_t>(random() % 60 + (positive ? 15 : 0));
    samples.emplace_back(score, positive);
    roc.Add(score, positive);
    (i % 2 == 0 ? first : second).Add(score, positive);
  }
  double won = 0.0, pairs = 0.0;
  for (const auto& [a, a_positive] : samples) {
    for (const auto& [b, b_positive] : samples) {
      if (a_positive && !b_positive) {
        won += a > b ? 1.0 : a == b ? 0.5 : 0.0;
        pairs += 1.0;
      }
    }
  }
  // Both sums are of halves below 2^53: exact; the division is the same.
  EXPECT_EQ(*roc.Auc(), won / pairs);
  first.Merge(second);
  EXPECT_EQ(*first.Auc(), *roc.Auc());
  EXPECT_EQ(first.positive_count() + first.negative_count(), 400);
}

}  // namespace
}  // namespace egosieve::tools
