#include "vision/baselines/platt_sigmoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace egosieve::vision {
namespace {

// With decisions -1 and 1 only, (PS2) has a closed form: each value's probability is the mean
// target of its points. Of 10 points at 1, 8 are positive; of 10 at -1, 3 are: N+ = 11, N- = 9.
TEST(FitPlattSigmoid, TwoValuesGetTheirMeanTargets) {
  std::vector<double> decisions;
  std::vector<uint8_t> positive;
  for (int i = 0; i < 10; ++i) {
    decisions.push_back(1.0);
    positive.push_back(i < 8 ? 1 : 0);
    decisions.push_back(-1.0);
    positive.push_back(i < 3 ? 1 : 0);
  }
  const auto sigmoid = FitPlattSigmoid(decisions, positive);
  ASSERT_TRUE(sigmoid.ok()) << sigmoid.status();
  const double high = 12.0 / 13.0, low = 1.0 / 11.0;
  // The gradient, a sum over 20 points of curvature above 0.15, ends below 1e-5.
  EXPECT_NEAR(sigmoid->Probability(1.0), 0.8 * high + 0.2 * low, 1e-5);
  EXPECT_NEAR(sigmoid->Probability(-1.0), 0.3 * high + 0.7 * low, 1e-5);
  EXPECT_LT(sigmoid->a, 0.0);
}

// 4,000 draws of a known sigmoid: a and b have standard errors of about 0.05; four of them.
TEST(FitPlattSigmoid, FindsTheSigmoidThatMadeTheLabels) {
  const PlattSigmoid truth{-2.0, 0.7};
  std::mt19937_64 random(11);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<double> decisions;
  std::vector<uint8_t> positive;
  for (int i = 0; i < 4000; ++i) {
    decisions.push_back(6.0 * uniform() - 3.0);
    positive.push_back(uniform() < truth.Probability(decisions.back()) ? 1 : 0);
  }
  const auto sigmoid = FitPlattSigmoid(decisions, positive);
  ASSERT_TRUE(sigmoid.ok());
  EXPECT_NEAR(sigmoid->a, truth.a, 0.3);
  EXPECT_NEAR(sigmoid->b, truth.b, 0.25);
}

TEST(FitPlattSigmoid, SeparableAndOneSidedDataStayFinite) {
  const auto separable = FitPlattSigmoid({-2.0, -1.0, 1.0, 2.0}, {0, 0, 1, 1});
  ASSERT_TRUE(separable.ok());
  EXPECT_TRUE(std::isfinite(separable->a) && std::isfinite(separable->b));
  EXPECT_GT(separable->Probability(2.0), 0.6);
  const auto negatives = FitPlattSigmoid({-1.0, 0.5, 3.0}, {0, 0, 0});
  ASSERT_TRUE(negatives.ok());
  EXPECT_NEAR(negatives->Probability(0.5), 0.2, 0.02);  // 1 / (N- + 2)
}

TEST(FitPlattSigmoid, RefusesWhatIsNoData) {
  EXPECT_FALSE(FitPlattSigmoid({1.0}, {}).ok());
  EXPECT_FALSE(FitPlattSigmoid({std::numeric_limits<double>::quiet_NaN()}, {1}).ok());
}

}  // namespace
}  // namespace egosieve::vision
