#include "vision/paper/ransac.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/geometry/synthetic_pairs.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

using testing::CameraMotion;
using testing::MakeSyntheticPairs;
using testing::SyntheticOptions;
using testing::SyntheticPairs;

// Root mean square residual over the static pairs.
template <typename Distance>
double StaticRms(const SyntheticPairs& scene, const Eigen::Matrix3d& matrix, Distance distance) {
  double sum = 0.0, n = 0.0;
  for (size_t i = 0; i < scene.pairs.size(); ++i) {
    if (scene.is_mover[i]) continue;
    const double d = distance(matrix, scene.pairs[i]);
    sum += d * d;
    n += 1.0;
  }
  return std::sqrt(sum / n);
}

SyntheticPairs NoisyScene(CameraMotion motion, double outlier_share, int seed) {
  SyntheticOptions options;
  options.motion = motion;
  options.mover_share = 0.2;
  options.outlier_share = outlier_share;
  options.noise_pixels = 0.3;
  options.seed = seed;
  return MakeSyntheticPairs(options);
}

TEST(EstimateFundamental, FitsTheStaticWorldAsWellAsTheTruth) {
  for (const CameraMotion motion : {CameraMotion::kForward, CameraMotion::kSideways}) {
    for (int seed = 1; seed <= 10; ++seed) {
      const SyntheticPairs scene = NoisyScene(motion, 0.2, seed);
      RansacOptions ransac;
      ransac.seed = seed;
      const auto result = Value(EstimateFundamental(scene.pairs, ransac));
      const double truth = StaticRms(scene, scene.fundamental, SampsonDistance);
      EXPECT_NEAR(truth, 0.3, 0.03) << "the test's own scene";
      EXPECT_LT(StaticRms(scene, result.matrix, SampsonDistance), 1.15 * truth) << seed;
      EXPECT_LT(std::abs(result.matrix.determinant()), 1e-12);
    }
  }
}

TEST(EstimateHomography, FitsAsWellAsTheTruth) {
  for (const CameraMotion motion : {CameraMotion::kRotation, CameraMotion::kPlanar}) {
    for (int seed = 1; seed <= 10; ++seed) {
      const SyntheticPairs scene = NoisyScene(motion, 0.3, seed);
      RansacOptions ransac;
      ransac.seed = seed;
      const auto result = Value(EstimateHomography(scene.pairs, ransac));
      EXPECT_LT(StaticRms(scene, result.matrix, TransferDistance),
                1.05 * StaticRms(scene, scene.homography, TransferDistance))
          << seed;
    }
  }
}

TEST(EstimateFundamental, NinetyFivePercentOutliersEndInBoundedWork) {
  SyntheticOptions options;
  options.mover_share = 0.0;
  options.outlier_share = 0.95;
  RansacOptions ransac;
  const auto result = Value(EstimateFundamental(MakeSyntheticPairs(options).pairs, ransac));
  EXPECT_LE(result.iterations, 2000);
}

TEST(Ransac, SameSeedSameBytes) {
  SyntheticOptions options;
  options.outlier_share = 0.3;
  const SyntheticPairs scene = MakeSyntheticPairs(options);
  for (const auto estimate : {EstimateFundamental, EstimateHomography}) {
    const auto a = Value(estimate(scene.pairs, {})), b = Value(estimate(scene.pairs, {}));
    EXPECT_EQ(std::memcmp(a.matrix.data(), b.matrix.data(), sizeof(double) * 9), 0);
    RansacOptions other;
    other.seed = 99;
    const auto c = Value(estimate(scene.pairs, other));
    EXPECT_NE(std::memcmp(a.matrix.data(), c.matrix.data(), sizeof(double) * 9), 0)
        << "the seed has no effect";
  }
}

TEST(Ransac, DegenerateInputsAreErrorsNotCrashes) {
  std::vector<PointPair> collinear, few(3);
  for (int i = 0; i < 200; ++i) collinear.push_back({1.0 * i, 3.0 * i, 1.0 * i + 2, 3.0 * i - 5});
  const std::vector<PointPair> identical(200, PointPair{1, 2, 3, 4});
  for (const auto estimate : {EstimateFundamental, EstimateHomography}) {
    EXPECT_THAT(estimate(few, {}), IsInvalid());
    EXPECT_EQ(estimate(identical, {}).status().code(), absl::StatusCode::kNotFound);
    EXPECT_EQ(estimate(collinear, {}).status().code(), absl::StatusCode::kNotFound);
  }
}

}  // namespace
}  // namespace egosieve::vision
