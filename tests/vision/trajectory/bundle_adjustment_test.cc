#include "vision/trajectory/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/evidence/point_street.h"
#include "vision/trajectory/parallax_prior.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;
using Directions = std::vector<Vector3d>;
constexpr int kPictures = 6;

// Of the first frames of a street.
TrackWindow WindowOf(const PointStreet& street) {
  TrackWindow window;
  window.pictures = kPictures;
  for (int64_t i = 0; i < street.size(); ++i) {
    std::vector<cv::Point2d> track;
    for (int k = 0; k < kPictures; ++k) {
      const Eigen::Vector2d place = street.Place(i, k);
      if (!street.Inside(place)) break;
      track.emplace_back(place(0), place(1));
    }
    if (track.size() >= 3) window.tracks.push_back(track);
  }
  return window;
}

std::vector<TrackWindow> WindowsOf(const StreetOptions& options) {
  std::vector<TrackWindow> windows;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    StreetOptions changed = options;
    changed.seed = seed;
    windows.push_back(WindowOf(PointStreet(changed)));
  }
  return windows;
}

StreetOptions Turning(double focal) {
  StreetOptions options;
  options.size = {800, 600};
  options.focal_pixels = focal;
  options.static_count = 300;
  options.yaw = 0.03;
  options.pitch = 0.01;
  options.noise_pixels = 0.2;
  options.travel = {0.0, 0.0, 0.2};
  return options;
}

// The noise is independent here, so the errors are smaller than what a window that counts as 30
// observations lets expect.
void ExpectWithinDeviation(const AdjustedLens& lens, double ratio) {
  EXPECT_LT(std::abs(std::log(lens.focal_ratio / ratio)), lens.log_focal_deviation);
}

TEST(BundleAdjustment, TurnsTellTheFocalLength) {
  for (const double focal : {400.0, 560.0, 1400.0}) {
    const AdjustedLens lens = AdjustLens(WindowsOf(Turning(focal)), {800, 600});
    ExpectWithinDeviation(lens, focal / 800);
    EXPECT_EQ(lens.windows, 4);
    EXPECT_LT(lens.log_focal_deviation, 0.05) << focal;
    EXPECT_NEAR(lens.noise_pixels, 0.2, 0.05) << focal;
    EXPECT_EQ(lens.k1, 0.0) << focal;
  }
}

// The pictures of a barrel and of a pincushion.
TEST(BundleAdjustment, TurnsTellTheDistortion) {
  for (const double k1 : {-0.3, 0.1}) {
    AdjustedLens truth;
    truth.focal_ratio = 560.0 / 800;
    truth.k1 = k1;
    truth.course = 1.0;
    const Lens lens = LensOf(truth, {800, 600});
    std::vector<TrackWindow> windows = WindowsOf(Turning(560.0));
    for (TrackWindow& window : windows) {
      for (auto& track : window.tracks) {
        for (cv::Point2d& place : track) {
          const auto [x, y] = lens.Project((place.x - 399.5) / 560.0, (place.y - 299.5) / 560.0);
          place = {x - 0.5, y - 0.5};
        }
      }
    }
    const AdjustedLens found = AdjustLens(windows, {800, 600});
    ExpectWithinDeviation(found, truth.focal_ratio);
    EXPECT_NEAR(found.k1, k1, 0.02);
    EXPECT_EQ(AdjustLens(windows, {800, 600}, Distortion::kNone).k1, 0.0);
  }
}

TEST(BundleAdjustment, ACameraThatOnlyTurnsTellsTheFocalLength) {
  StreetOptions options = Turning(560.0);
  options.travel.setZero();
  const AdjustedLens lens = AdjustLens(WindowsOf(options), {800, 600});
  ExpectWithinDeviation(lens, 560.0 / 800);
  EXPECT_LT(lens.log_focal_deviation, 0.1);
}

TEST(BundleAdjustment, MoversAreOutliers) {
  StreetOptions options = Turning(560.0);
  options.mover_count = 100;
  options.mover_travel = {0.3, 0.0, 0.5};
  ExpectWithinDeviation(AdjustLens(WindowsOf(options), {800, 600}), 560.0 / 800);
}

TEST(BundleAdjustment, ADriveStraightAheadIsNotCertain) {
  StreetOptions options = Turning(560.0);
  options.yaw = options.pitch = 0.0;
  options.travel = {0.0, 0.0, 0.5};
  EXPECT_GT(AdjustLens(WindowsOf(options), {800, 600}).log_focal_deviation, 0.2);
}

TEST(BundleAdjustment, WithoutPlacesThePriorHolds) {
  for (const AdjustedLens& lens :
       {AdjustLens({}, {640, 480}), AdjustLens({TrackWindow{4, {}}}, {640, 480})}) {
    EXPECT_EQ(lens.windows, 0);
    EXPECT_EQ(lens.focal_ratio, 0.7);
  }
  // Nothing moves.
  TrackWindow still{4, {}};
  for (int i = 0; i < 100; ++i) {
    still.tracks.emplace_back(4, cv::Point2d(37.0 * i - 640.0 * (37 * i / 640), 4.0 * i + 20.0));
  }
  const AdjustedLens lens = AdjustLens({still}, {640, 480});
  EXPECT_NEAR(lens.focal_ratio, 0.7, 0.07);
  // That of the prior's curvature, 0.4 sqrt(3 / 4).
  EXPECT_NEAR(lens.log_focal_deviation, 0.346, 0.001);
}

// Its last picture would have no pose.
TEST(BundleAdjustment, AWindowThatNoTrackCrossesIsLeftOut) {
  std::vector<TrackWindow> windows = WindowsOf(Turning(560.0));
  const AdjustedLens without = AdjustLens(windows, {800, 600});
  windows.push_back(windows[0]);
  for (auto& track : windows.back().tracks) track.resize(std::min<size_t>(track.size(), 3));
  ASSERT_GT(windows.back().pictures, 3);
  const AdjustedLens with = AdjustLens(windows, {800, 600});
  EXPECT_EQ(with.windows, without.windows);
  EXPECT_EQ(with.focal_ratio, without.focal_ratio);
}

TEST(BundleAdjustment, GivesTheSameBitsAgain) {
  const std::vector<TrackWindow> windows = WindowsOf(Turning(560.0));
  const AdjustedLens first = AdjustLens(windows, {800, 600});
  // Other addresses.
  const std::vector<std::vector<double>> held(50, std::vector<double>(1000));
  const AdjustedLens second = AdjustLens(std::vector<TrackWindow>(windows), {800, 600});
  EXPECT_EQ(first.focal_ratio, second.focal_ratio);
  EXPECT_EQ(first.log_focal_deviation, second.log_focal_deviation);
}

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
