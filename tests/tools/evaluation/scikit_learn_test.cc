// The same arrays through scikit-learn 1.2.1: its values, written down once.
//
// The arrays come from a linear congruential generator that takes one line in either language:
//   x_0 = 20260,  x_{i+1} = (1103515245 x_i + 12345) mod 2^31,  draw = x >> 8
// Per sample: truth = draw mod 10 < 3; score = 133 (draw mod 200 + draw mod 200 + 90 truth), with
// many ties; deviation = 131 (draw mod 500).
#include <gtest/gtest.h>

#include <cstdint>

#include "tools/evaluation/calibration.h"
#include "tools/evaluation/roc.h"

namespace egosieve::tools {
namespace {

// Sums of 2,000 terms below 1, by another order of operations: 2,000 eps is 4.4e-13.
constexpr double kTolerance = 1e-12;

class ScikitLearnTest : public ::testing::Test {
 protected:
  ScikitLearnTest() {
    for (int i = 0; i < 2000; ++i) {
      const bool positive = Draw() % 10 < 3;
      const int first = static_cast<int>(Draw() % 200), second = static_cast<int>(Draw() % 200);
      const auto score = static_cast<uint16_t>(133 * (first + second + (positive ? 90 : 0)));
      const auto deviation = static_cast<uint16_t>(131 * (Draw() % 500));
      scores_.Add(score, positive);
      wrong_.Add(deviation, (score >= 40000) != positive);
    }
  }

  uint64_t Draw() {
    x_ = (1103515245 * x_ + 12345) % (uint64_t{1} << 31);
    return x_ >> 8;
  }

  uint64_t x_ = 20260;
  RocHistogram scores_;
  RocHistogram wrong_;
};

TEST_F(ScikitLearnTest, RankingMetrics) {
  ASSERT_EQ(scores_.positive_count(), 605);
  EXPECT_NEAR(*scores_.Auc(), 0.7915850587991351, kTolerance);  // roc_auc_score
  EXPECT_NEAR(*scores_.AveragePrecision(), 0.6569808436034508,
              kTolerance);  // average_precision_score
  EXPECT_NEAR(*wrong_.Auc(), 0.47566481711480657, kTolerance);
  // roc_curve(drop_intermediate=False): 414 distinct scores and the origin.
  EXPECT_EQ(scores_.Curve(1 << 20).size(), 415u);
}

TEST_F(ScikitLearnTest, MetricsAtAThreshold) {
  const Confusion low = scores_.At(30000), high = scores_.At(40000);
  EXPECT_NEAR(*low.F(), 0.5964691046658259, kTolerance);           // f1_score
  EXPECT_NEAR(*low.Iou(), 0.4249775381850854, kTolerance);         // jaccard_score
  EXPECT_NEAR(*low.Precision(), 0.48216106014271154, kTolerance);  // precision_score
  EXPECT_NEAR(*low.Recall(), 0.7818181818181819, kTolerance);      // recall_score
  EXPECT_NEAR(*high.F(), 0.5313092979127134, kTolerance);
  EXPECT_NEAR(*high.Iou(), 0.36175710594315247, kTolerance);
}

TEST_F(ScikitLearnTest, CalibrationMetrics) {
  const Calibration calibration = *CalibrationOf(scores_, 10);
  EXPECT_NEAR(calibration.brier, 0.18804507813473142, kTolerance);    // brier_score_loss
  EXPECT_NEAR(calibration.log_loss, 0.5549427947547501, kTolerance);  // log_loss, clipped alike
  // calibration_curve(n_bins=10), weighted by the bins' sizes.
  EXPECT_NEAR(calibration.expected_calibration_error, 0.16715997558556495, kTolerance);
  EXPECT_EQ(calibration.bins[3].pixels, 387);
  EXPECT_NEAR(calibration.bins[3].positive_share, 0.13953488, 1e-8);  // as printed
  EXPECT_NEAR(calibration.bins[3].mean_stated, 0.34814768, 1e-8);
}

}  // namespace
}  // namespace egosieve::tools
