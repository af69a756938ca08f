#include "vision/trajectory/travel_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;
using Directions = std::vector<Vector3d>;

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
