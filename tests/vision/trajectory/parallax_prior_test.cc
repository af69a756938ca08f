#include "vision/trajectory/parallax_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace egosieve::vision {
namespace {

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
      EXPECT_NEAR(EvaluateParallax(s, mean, 0.4).log_density, expected,
                  1e-6 * (1 + std::abs(expected)))
          << mean << " " << s;
    }
  }
}

TEST(ParallaxPrior, SlopeAndCurvatureAreDerivatives) {
  constexpr double kStep = 1e-4;
  for (const double mean : {0.02, 0.5, 20.0}) {
    for (const double s : {-4.0, -2.0, 0.1, 3.0}) {
      const auto at = [&](double x) { return EvaluateParallax(x, mean, 0.5); };
      // Central differences: the error is of the order of step^2 times the next derivative.
      const double slope = (at(s + kStep).log_density - at(s - kStep).log_density) / (2 * kStep);
      const double curvature = -(at(s + kStep).slope - at(s - kStep).slope) / (2 * kStep);
      EXPECT_NEAR(at(s).slope, slope, 1e-5 * (1 + std::abs(slope)));
      EXPECT_NEAR(at(s).curvature, curvature, 1e-5 * (1 + std::abs(curvature)));
      EXPECT_GE(at(s).curvature, 0.0);
    }
  }
}

// A camera that only turns: the prior's mean far below the noise leaves a Gaussian.
TEST(ParallaxPrior, BecomesAGaussianWhereTheMeanVanishes) {
  for (const double s : {-1.0, 0.0, 1.5}) {
    const double gaussian = -0.5 * s * s - 0.5 * std::log(2.0 * std::numbers::pi);
    // The mean moves by m = 0.001, the logarithm by at most m |s| + m^2.
    EXPECT_NEAR(EvaluateParallax(s, 1e-3, 1.0).log_density, gaussian, 2e-3);
  }
}

}  // namespace
}  // namespace egosieve::vision
