#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "vision/trajectory/parallax_prior.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {
namespace {

using Directions = std::vector<Vector3d>;
using Eigen::Vector3d;
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

Vector3d AnyDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

// `along` about `mean`, each component off by `spread`, then `others` anywhere.
Directions Mixed(const Vector3d& mean, int along, int others, uint32_t seed, double spread = 0.05) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, spread);
  Directions directions;
  for (int k = 0; k < along; ++k) {
    const Vector3d off(normal(random), normal(random), normal(random));
    directions.push_back((mean + off).normalized());
  }
  for (int k = 0; k < others; ++k) directions.push_back(AnyDirection(random));
  return directions;
}

// The density relative to the uniform one has a mean of 1 over the sphere.
TEST(TravelPrior, IsADensity) {
  TravelPrior prior;
  prior.direction = Vector3d(0.6, 0.0, 0.8);
  prior.concentration = 20.0;
  prior.share = 0.7;
  constexpr int kCount = 20000;
  double sum = 0.0;
  for (int k = 0; k < kCount; ++k) {  // Fibonacci's lattice
    const double z = 1.0 - (2.0 * k + 1.0) / kCount, radius = std::sqrt(1.0 - z * z);
    const double angle = 2.399963229728653 * k;
    sum +=
        std::exp(prior.LogDensity(Vector3d(radius * std::cos(angle), radius * std::sin(angle), z)));
  }
  EXPECT_NEAR(sum / kCount, 1.0, 1e-3);
}

TEST(TravelPrior, FindsAVehiclesDirectionAmongWrongOnes) {
  const Vector3d forward = Vector3d(0.02, 0.03, -1.0).normalized();
  const TravelPrior prior = FitTravelPrior(Mixed(forward, 16, 8, 5));
  ASSERT_TRUE(prior.IsKnown());
  // The mean of 16 directions that are 0.05 off in each component is 0.0125 off in each.
  EXPECT_GT(prior.direction.dot(forward), std::cos(3.0 * 0.0125 * std::sqrt(2.0)));
  EXPECT_NEAR(prior.share, 16.0 / 26.0, 0.05);
  EXPECT_GT(prior.Membership(forward), 0.95);
  EXPECT_LT(prior.Membership(Vector3d::UnitX()), 1e-6);
  EXPECT_GT(prior.LogDensity(forward), 4.0);
}

TEST(TravelPrior, AVehicleTravelsForwardOrBackMostOfTheTime) {
  const Vector3d forward = -Vector3d::UnitZ();
  EXPECT_TRUE(FitTravelPrior(Mixed(forward, 16, 8, 5)).IsOfVehicle());
  EXPECT_TRUE(FitTravelPrior(Mixed(-forward, 16, 8, 5)).IsOfVehicle());
  EXPECT_FALSE(FitTravelPrior(Mixed(Vector3d::UnitX(), 16, 8, 5)).IsOfVehicle());
  EXPECT_FALSE(FitTravelPrior(Mixed(forward, 8, 16, 5)).IsOfVehicle());
  EXPECT_FALSE(FitTravelPrior(Mixed(forward, 24, 0, 5, 0.11)).IsOfVehicle());  // walking
}

// Of a camera that travels anywhere no direction is ruled out.
TEST(TravelPrior, ACarriedCameraHasHardlyAny) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    const TravelPrior prior = FitTravelPrior(Mixed(Vector3d::UnitZ(), 0, 24, seed));
    for (int k = 0; k < 50; ++k) EXPECT_GT(prior.LogDensity(AnyDirection(random)), -1.5);
    EXPECT_LT(prior.share, 0.75);
  }
}

TEST(TravelPrior, FewDirectionsSayNothing) {
  EXPECT_FALSE(FitTravelPrior({}).IsKnown());
  EXPECT_FALSE(FitTravelPrior(Directions(5, Vector3d::UnitZ())).IsKnown());
  const TravelPrior none;
  EXPECT_EQ(none.LogDensity(Vector3d::UnitX()), 0.0);
}

TEST(TravelPrior, EqualDirectionsAreKnownNoBetterThanThreeDegrees) {
  const TravelPrior prior = FitTravelPrior(Directions(24, Vector3d::UnitY()));
  ASSERT_TRUE(prior.IsKnown());
  EXPECT_LE(prior.concentration, 400.0);
  EXPECT_NEAR((prior.direction - Vector3d::UnitY()).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace egosieve::vision
