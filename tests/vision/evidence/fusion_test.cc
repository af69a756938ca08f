#include "vision/evidence/fusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace egosieve::vision {
namespace {

// Simpson's rule.
template <typename F>
double Integral(const F& f, double from, double to, int steps = 20000) {
  const double h = (to - from) / steps;
  double sum = f(from) + f(to);
  for (int i = 1; i < steps; ++i) sum += (i % 2 == 1 ? 4 : 2) * f(from + i * h);
  return sum * h / 3;
}

double StudentDensity(double x) {
  return 2.0 / (M_PI * std::sqrt(3.0)) / ((1 + x * x / 3) * (1 + x * x / 3));
}

TEST(Fusion, StudentThreeIsTheIntegralOfItsDensity) {
  for (const double z : {-5.0, -1.0, 0.0, 0.5, 3.0}) {
    // The tail beyond -2000 is below 1e-10; Simpson's error is far below that.
    EXPECT_NEAR(StudentThree(z),
                Integral(StudentDensity, -2000, -20, 200000) + Integral(StudentDensity, -20, z),
                1e-8);
  }
}

// exp of the ratio times the static density must be a density: of movers.
TEST(Fusion, DistanceRatioIsThatOfTwoDensities) {
  const auto dynamic = [](double z) {
    return 2 * StudentDensity(z) * std::exp(DistanceLogRatio(z));
  };
  const double limit = 3000;
  // Cauchy's tail beyond the limit: 2/pi S / limit.
  EXPECT_NEAR(Integral(dynamic, 0, limit, 300000), 1 - 2 / M_PI * kMoverScale / limit, 1e-5);
}

TEST(Fusion, RatiosAreFiniteAndOrdered) {
  double previous = DistanceLogRatio(0);
  EXPECT_LT(previous, -1);
  for (const double z :
       {1.0, 3.0, 10.0, 100.0, 1e4, 1e9, std::numeric_limits<double>::infinity()}) {
    const double ratio = DistanceLogRatio(z);
    EXPECT_TRUE(std::isfinite(ratio)) << z;
    EXPECT_GE(ratio, previous) << z;
    EXPECT_EQ(ratio, DistanceLogRatio(-z));
    previous = ratio;
  }
  EXPECT_GT(DistanceLogRatio(30), 4);
  EXPECT_EQ(DistanceLogRatio(std::nan("")), 0);
  EXPECT_EQ(DepthLogRatio(std::nan("")), 0);
}

TEST(Fusion, ALabelTellsSomethingWhereEvidenceMovesItFromTheShareOfMovers) {
  for (const double share : {0.01, 0.1, 0.5}) {
    for (const double ratio : {0.0, 0.09, -0.09}) {
      EXPECT_FALSE(Tells(ProbabilityOf(ratio, share), share)) << share << ' ' << ratio;
    }
    for (const double ratio : {0.11, -0.11, 12.0, -12.0, 1e3, -1e3}) {
      EXPECT_TRUE(Tells(ProbabilityOf(ratio, share), share)) << share << ' ' << ratio;
    }
  }
}

TEST(Fusion, OnlyNegativeDepthsSayAnything) {
  EXPECT_EQ(DepthLogRatio(0), 0);
  EXPECT_EQ(DepthLogRatio(50), 0);
  EXPECT_NEAR(DepthLogRatio(-3), -std::log(2 * StudentThree(-3)), 1e-12);
  EXPECT_GT(DepthLogRatio(-3), 2);
  EXPECT_TRUE(std::isfinite(DepthLogRatio(-1e30)));
  EXPECT_GT(DepthLogRatio(-1e30), DepthLogRatio(-100));
}

TEST(Fusion, HiddenMoversCapWhatATermSaysForStandingStill) {
  constexpr EvidenceTerm kTerm = EvidenceTerm::kEpipolar;
  const double hidden = kHiddenShare[static_cast<int>(kTerm)];
  EXPECT_NEAR(VisibleLogRatio(kTerm, -1000), std::log(hidden), 1e-12);
  EXPECT_NEAR(VisibleLogRatio(kTerm, 0), 0, 1e-12);
  EXPECT_NEAR(VisibleLogRatio(kTerm, 50.001), VisibleLogRatio(kTerm, 49.999), 0.01);
  EXPECT_TRUE(std::isfinite(VisibleLogRatio(kTerm, 1e4)));
  EXPECT_NEAR(VisibleLogRatio(EvidenceTerm::kNegativeDepth, 2), 2, 1e-12);
}

TEST(Fusion, ProbabilityIsBayes) {
  EXPECT_NEAR(ProbabilityOf(0, 0.2), 0.2, 1e-12);
  EXPECT_NEAR(ProbabilityOf(std::log(4), 0.2), 0.5, 1e-12);
  EXPECT_EQ(ProbabilityOf(1e9, 0.2), 1);
  EXPECT_EQ(ProbabilityOf(-1e9, 0.2), 0);
}

TEST(Fusion, ShareOfMoversIsFound) {
  for (const double share : {0.05, 0.2, 0.4}) {
    std::vector<double> ratios(1000, -6.0);
    for (size_t i = 0; i < 1000 * share; ++i) ratios[i] = 6.0;
    // The overlap of exp(+-6) is 0.25 %; steps end below 1e-4.
    EXPECT_NEAR(EstimateMoverShare(ratios, 0.1), share, 0.005);
  }
  EXPECT_EQ(EstimateMoverShare({}, 0.3), 0.3);
  EXPECT_EQ(EstimateMoverShare(std::vector<double>(50, 20.0), 0.3), 0.5);
  EXPECT_EQ(EstimateMoverShare(std::vector<double>(50, -20.0), 0.3), 0.01);
}

}  // namespace
}  // namespace egosieve::vision
