#include "vision/labelling/label_rule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "tests/vision/geometry/synthetic_pairs.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

using testing::CameraMotion;

double Normal(std::mt19937_64& engine) {
  const double u = 1.0 - static_cast<double>(engine() >> 11) * 0x1p-53;
  const double v = static_cast<double>(engine() >> 11) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * 3.14159265358979323846 * v);
}

double Uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

// Distances drawn from the very mixture: to lines (dimension 1) or points (2).
struct Draw {
  std::vector<double> distances;
  std::vector<bool> is_mover;
};

Draw DrawMixture(int count, int dimension, double sigma, double share, double range,
                 uint64_t seed) {
  std::mt19937_64 engine(seed);
  Draw draw;
  for (int i = 0; i < count; ++i) {
    const bool mover = Uniform(engine) < share;
    double d;
    if (mover) {
      d = range * (dimension == 1 ? Uniform(engine) : std::sqrt(Uniform(engine)));
    } else {
      d = dimension == 1 ? std::abs(sigma * Normal(engine))
                         : sigma * std::hypot(Normal(engine), Normal(engine));
    }
    draw.distances.push_back(d);
    draw.is_mover.push_back(mover);
  }
  return draw;
}

// Expected calibration error over ten bins: sum_b |sum p - movers| / n.
double CalibrationError(const std::vector<double>& p, const std::vector<bool>& is_mover) {
  double predicted[10] = {}, movers[10] = {};
  for (size_t i = 0; i < p.size(); ++i) {
    const int bin = std::min(9, static_cast<int>(10 * p[i]));
    predicted[bin] += p[i];
    movers[bin] += is_mover[i];
  }
  double error = 0.0;
  for (int bin = 0; bin < 10; ++bin) error += std::abs(predicted[bin] - movers[bin]);
  return error / static_cast<double>(p.size());
}

TEST(ScaledMedianLabels, LinearThenClampedAndNothingDiscarded) {
  const std::vector<double> labels = ScaledMedianLabels({0.0, 1.2, 2.4, 500.0}, 0.2, 12.0);
  ASSERT_EQ(labels.size(), 4u);
  EXPECT_DOUBLE_EQ(labels[0], 0.0);
  EXPECT_DOUBLE_EQ(labels[1], 0.5);
  EXPECT_DOUBLE_EQ(labels[2], 1.0);
  EXPECT_DOUBLE_EQ(labels[3], 1.0);
}

TEST(EstimateMixtureLabels, RecoversNoiseAndShareAndIsCalibrated) {
  for (const int dimension : {1, 2}) {
    for (const double share : {0.0, 0.1, 0.4}) {
      MixtureOptions options;
      options.residual_dimension = dimension;
      const Draw draw = DrawMixture(5000, dimension, 0.5, share, options.range_pixels, 7);
      const MixtureLabels labels = EstimateMixtureLabels(draw.distances, {}, options);
      // Relative standard error of sigma from 3000 and more: 1 / sqrt(2 * 3000) = 1.3 %, of the
      // share 0.7 %: movers within the noise are few (range 60 sigma). Four of them.
      EXPECT_NEAR(labels.state.noise_pixels, 0.5, 0.05 * 0.5) << dimension << " " << share;
      EXPECT_NEAR(labels.state.dynamic_share, share, 0.03) << dimension << " " << share;
      EXPECT_LT(CalibrationError(labels.probability, draw.is_mover), 0.02);
    }
  }
}

TEST(EstimateMixtureLabels, RisesWithDistanceAndNeverLeavesItsRange) {
  const Draw draw = DrawMixture(2000, 1, 0.3, 0.2, 30.0, 9);
  std::vector<double> sorted = draw.distances;
  sorted.push_back(1e9);
  std::sort(sorted.begin(), sorted.end());
  const MixtureLabels labels = EstimateMixtureLabels(sorted, {}, {});
  for (size_t i = 0; i < sorted.size(); ++i) {
    EXPECT_TRUE(labels.probability[i] >= 0 && labels.probability[i] <= 1);
    if (i > 0) {
      EXPECT_GE(labels.probability[i], labels.probability[i - 1]);
    }
  }
}

// A frame with little evidence of its own leans on the ones before.
TEST(EstimateMixtureLabels, MemoryDrawsTowardsThePreviousFrame) {
  const Draw draw = DrawMixture(200, 1, 0.5, 0.1, 30.0, 11);
  const double alone = EstimateMixtureLabels(draw.distances, {}, {}).state.noise_pixels;
  const double with = EstimateMixtureLabels(draw.distances, {1.0, 0.1}, {}).state.noise_pixels;
  EXPECT_GT(with, alone);
  EXPECT_LT(with, 1.0);
}

TEST(EstimateMixtureLabels, DegenerateFrames) {
  EXPECT_TRUE(EstimateMixtureLabels({}, {0.4, 0.1}, {}).probability.empty());
  EXPECT_EQ(EstimateMixtureLabels({}, {0.4, 0.1}, {}).state.noise_pixels, 0.4);
  for (const double value : {0.0, 1e-9, 25.0, 1e12}) {
    const MixtureLabels labels = EstimateMixtureLabels(std::vector<double>(50, value), {}, {});
    for (const double p : labels.probability) EXPECT_TRUE(p >= 0 && p <= 1) << value;
    EXPECT_TRUE(std::isfinite(labels.state.noise_pixels)) << value;
  }
}

// The whole way on made-up pairs of frames: the labels' calibration error over all motions, mover
// shares and noise levels.
TEST(EstimateMixtureLabels, CalibratedOnSyntheticPairs) {
  const std::pair<CameraMotion, const char*> motions[] = {{CameraMotion::kStatic, "static"},
                                                          {CameraMotion::kRotation, "rotation"},
                                                          {CameraMotion::kPlanar, "planar"},
                                                          {CameraMotion::kForward, "forward"},
                                                          {CameraMotion::kSideways, "sideways"}};
  std::vector<double> probability;
  std::vector<bool> is_mover;
  for (const auto& [motion, name] : motions) {
    std::vector<double> p;
    std::vector<bool> y;
    for (int i = 0; i < 40; ++i) {
      testing::SyntheticOptions scene;
      scene.motion = motion;
      scene.count = 1200;
      scene.mover_share = 0.4 * (i % 5) / 4.0;
      scene.noise_pixels = (i % 11) / 10.0;
      scene.seed = 500 + i;
      const testing::SyntheticPairs pairs = testing::MakeSyntheticPairs(scene);
      const auto model = EstimateMotionModel(pairs.pairs, {});
      ASSERT_TRUE(model.ok());
      MixtureOptions options;
      options.residual_dimension = model->kind == MotionModelKind::kFundamental ? 1 : 2;
      const MixtureLabels labels = EstimateMixtureLabels(
          Residuals(model->kind, model->matrix, pairs.pairs, EpipolarDistance::kSampson), {},
          options);
      p.insert(p.end(), labels.probability.begin(), labels.probability.end());
      y.insert(y.end(), pairs.is_mover.begin(), pairs.is_mover.end());
    }
    std::printf("%-9s calibration error %.4f\n", name, CalibrationError(p, y));
    probability.insert(probability.end(), p.begin(), p.end());
    is_mover.insert(is_mover.end(), y.begin(), y.end());
  }
  const double error = CalibrationError(probability, is_mover);
  std::printf("all       calibration error %.4f\n", error);
  EXPECT_LE(error, 0.05);
}

}  // namespace
}  // namespace egosieve::vision
