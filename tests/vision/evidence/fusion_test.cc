#include "vision/evidence/fusion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::vision {
namespace {

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

TEST(Fusion, HiddenMoversCapWhatATermSaysForStandingStill) {
  constexpr EvidenceTerm kTerm = EvidenceTerm::kEpipolar;
  const double hidden = kHiddenShare[static_cast<int>(kTerm)];
  EXPECT_NEAR(VisibleLogRatio(kTerm, -1000), std::log(hidden), 1e-12);
  EXPECT_NEAR(VisibleLogRatio(kTerm, 0), 0, 1e-12);
  EXPECT_NEAR(VisibleLogRatio(kTerm, 50.001), VisibleLogRatio(kTerm, 49.999), 0.01);
  EXPECT_TRUE(std::isfinite(VisibleLogRatio(kTerm, 1e4)));
  EXPECT_NEAR(VisibleLogRatio(EvidenceTerm::kRoad, 2), 2, 1e-12);
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
