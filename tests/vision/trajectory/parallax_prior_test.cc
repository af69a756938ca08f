#include "vision/trajectory/parallax_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace egosieve::vision {
namespace {

struct Density {
  double log_density, slope, curvature;
};

Density DensityAt(double s, double mean, double deviation) {
  const ParallaxDensity<1> density = EvaluateParallax<1>(Lanes<1>(s), Lanes<1>(mean), deviation);
  return {density.log_density(0), density.slope(0), density.curvature(0)};
}

// (PP1) by Simpson's rule over twelve deviations around s, or from zero on.
double Integral(double s, double mean, double deviation) {
  const double low = std::max(0.0, s - 12.0 * deviation),
               high = std::max(s, 0.0) + 12.0 * deviation;
  constexpr int kSteps = 20000;
  const double step = (high - low) / kSteps;
  double sum = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double x = low + k * step, z = (s - x) / deviation;
    const double weight = k == 0 || k == kSteps ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * std::exp(-0.5 * z * z - x / mean);
  }
  return sum * step / 3.0 / (mean * deviation * std::sqrt(2.0 * std::numbers::pi));
}

TEST(ParallaxPrior, IsTheIntegralOverInverseDepth) {
  for (const double mean : {0.05, 0.3, 1.0, 7.0, 100.0}) {
    for (const double s : {-3.0, -1.0, 0.0, 0.5, 2.0, 9.0}) {
      const double expected = std::log(Integral(s, mean, 0.4));
      EXPECT_NEAR(DensityAt(s, mean, 0.4).log_density, expected, 1e-6 * (1 + std::abs(expected)))
          << mean << " " << s;
    }
  }
}

TEST(ParallaxPrior, SlopeAndCurvatureAreDerivatives) {
  constexpr double kStep = 1e-4;
  for (const double mean : {0.02, 0.5, 20.0}) {
    for (const double s : {-4.0, -2.0, 0.1, 3.0}) {
      const auto at = [&](double x) { return DensityAt(x, mean, 0.5); };
      // Central differences: the error is of the order of step^2 times the next derivative.
      const double slope = (at(s + kStep).log_density - at(s - kStep).log_density) / (2 * kStep);
      const double curvature = -(at(s + kStep).slope - at(s - kStep).slope) / (2 * kStep);
      EXPECT_NEAR(at(s).slope, slope, 1e-5 * (1 + std::abs(slope)));
      EXPECT_NEAR(at(s).curvature, curvature, 1e-5 * (1 + std::abs(curvature)));
      EXPECT_GE(at(s).curvature, 0.0);
    }
  }
}

// Far below the mean, where Phi underflows: Laplace's continued fraction of the Mills ratio.
TEST(ParallaxPrior, HoldsInTheTail) {
  for (const double a : {-7.0, -30.0, -300.0}) {
    double fraction = 0.0;
    for (int k = 60; k > 0; --k) fraction = k / (-a + fraction);
    const double ratio = -a + fraction;
    const double s = a + 1.0;  // of mean and deviation 1
    const double log_density =
        -0.5 * s * s - 0.5 * std::log(2.0 * std::numbers::pi) - std::log(ratio);
    EXPECT_NEAR(DensityAt(s, 1.0, 1.0).log_density, log_density, 1e-12 * std::abs(log_density));
    EXPECT_NEAR(DensityAt(s, 1.0, 1.0).slope, ratio - 1.0, 1e-12 * ratio);
  }
}

TEST(ParallaxPrior, LanesDoNotMix) {
  constexpr int kLanes = 8;
  Lanes<kLanes> s, mean;
  for (int k = 0; k < kLanes; ++k) {
    s(k) = k - 4.0;
    mean(k) = 0.1 * (k + 1);
  }
  const ParallaxDensity<kLanes> together = EvaluateParallax<kLanes>(s, mean, 0.7);
  for (int k = 0; k < kLanes; ++k) {
    const Density alone = DensityAt(s(k), mean(k), 0.7);
    // Vector and scalar functions of the libraries differ by a few roundings.
    EXPECT_NEAR(together.log_density(k), alone.log_density, 1e-13 * (1 + std::abs(s(k)) * 100));
    EXPECT_NEAR(together.slope(k), alone.slope, 1e-12 * (1 + std::abs(alone.slope)));
    EXPECT_NEAR(together.curvature(k), alone.curvature, 1e-11);
  }
}

// A camera that only turns: the prior's mean far below the noise leaves a Gaussian.
TEST(ParallaxPrior, BecomesAGaussianWhereTheMeanVanishes) {
  for (const double s : {-1.0, 0.0, 1.5}) {
    const double gaussian = -0.5 * s * s - 0.5 * std::log(2.0 * std::numbers::pi);
    // The mean moves by m = 0.001, the logarithm by at most m |s| + m^2.
    EXPECT_NEAR(DensityAt(s, 1e-3, 1.0).log_density, gaussian, 2e-3);
  }
}

}  // namespace
}  // namespace egosieve::vision
