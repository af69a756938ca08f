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

RocHistogram Sample() {
  // score: truth      5: +   4: -   4: +   2: -   1: -   1: +
  RocHistogram roc;
  for (const auto& [score, positive] : std::vector<std::pair<int, bool>>{
           {5, true}, {4, false}, {4, true}, {2, false}, {1, false}, {1, true}}) {
    roc.Add(static_cast<uint16_t>(score), positive);
  }
  return roc;
}

TEST(RocHistogram, AveragePrecisionByHand) {
  // Thresholds 5, 4, 1 add a third of the recall each, at precisions 1, 2/3 and 3/6.
  EXPECT_NEAR(*Sample().AveragePrecision(), (1.0 + 2.0 / 3.0 + 0.5) / 3.0, 1e-15);
  RocHistogram one_class;
  one_class.Add(7, true);
  EXPECT_FALSE(one_class.AveragePrecision().has_value());
}

TEST(RocHistogram, ThresholdsByHand) {
  const Confusion c = Sample().At(4);
  EXPECT_EQ(c.true_positives, 2);
  EXPECT_EQ(c.false_positives, 1);
  EXPECT_EQ(c.false_negatives, 1);
  EXPECT_EQ(c.true_negatives, 2);
  EXPECT_EQ(*c.Iou(), 0.5);
  EXPECT_EQ(*c.F(), 2.0 / 3.0);
  EXPECT_EQ(*c.FalsePositiveRate(), 1.0 / 3.0);
  // IoU is 1/3 at 5, 2/4 at 4, 2/5 at 2 and 3/6 at 1: the lowest of the best.
  EXPECT_EQ(*Sample().BestThreshold(), 0);
  EXPECT_EQ(Sample().At(0).true_positives, 3);
  EXPECT_EQ(Sample().At(65536).false_negatives, 3);
}

TEST(RocHistogram, RatiosOfNothingAreAbsent) {
  RocHistogram roc;
  roc.Add(3, false);
  const Confusion c = roc.At(100);
  EXPECT_FALSE(c.Precision().has_value());
  EXPECT_FALSE(c.Recall().has_value());
  EXPECT_FALSE(c.Iou().has_value());
  EXPECT_FALSE(c.F().has_value());
  EXPECT_EQ(*c.FalsePositiveRate(), 0.0);
  EXPECT_FALSE(roc.BestThreshold().has_value());
  EXPECT_TRUE(roc.Curve(10).empty());
}

TEST(RocHistogram, CurveHasTheAreaOfTheAucAndKeepsItsEnds) {
  const auto area = [](const std::vector<OperatingPoint>& curve) {
    double sum = 0.0;
    for (size_t i = 1; i < curve.size(); ++i) {
      sum += 0.5 * (curve[i].recall + curve[i - 1].recall) *
             (curve[i].false_positive_rate - curve[i - 1].false_positive_rate);
    }
    return sum;
  };
  EXPECT_NEAR(area(Sample().Curve(1000)), *Sample().Auc(), 1e-15);
  std::mt19937_64 random(4);
  RocHistogram roc;
  for (int i = 0; i < 20000; ++i) roc.Add(static_cast<uint16_t>(random()), random() % 4 == 0);
  const std::vector<OperatingPoint> curve = roc.Curve(100);
  EXPECT_LE(curve.size(), 100u);
  EXPECT_GE(curve.size(), 80u);
  EXPECT_EQ(curve.front().threshold, 65536);
  EXPECT_EQ(curve.back().recall, 1.0);
  EXPECT_EQ(curve.back().false_positive_rate, 1.0);
  // Between two points neither coordinate moves by more than 2/98 and a step of one pixel.
  EXPECT_NEAR(area(curve), *roc.Auc(), 1e-3);
}

TEST(RocHistogram, ScoresOfProbabilities) {
  EXPECT_EQ(ScoreOf(0.0), 0);
  EXPECT_EQ(ScoreOf(1.0), 65535);
  EXPECT_EQ(ScoreOf(1.7), 65535);
  EXPECT_EQ(ThresholdOf(0.5), 32768);
  EXPECT_LT(ScoreOf(0.499992), ThresholdOf(0.5));
}

}  // namespace
}  // namespace egosieve::tools
