#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/geometry/synthetic_pairs.h"
#include "vision/geometry/residual.h"
#include "vision/paper/ransac.h"

namespace egosieve::vision {
namespace {

using testing::CameraMotion;
using testing::MakeSyntheticPairs;
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

SyntheticPairs NoisyScene(CameraMotion motion, double outlier_share, uint64_t seed) {
  return MakeSyntheticPairs({.motion = motion,
                             .mover_share = 0.2,
                             .outlier_share = outlier_share,
                             .noise_pixels = 0.3,
                             .seed = seed});
}

TEST(EstimateFundamental, FitsTheStaticWorldAsWellAsTheTruth) {
  for (const CameraMotion motion : {CameraMotion::kForward, CameraMotion::kSideways}) {
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      const SyntheticPairs scene = NoisyScene(motion, 0.2, seed);
      const auto result = Value(EstimateFundamental(scene.pairs, 0.5, seed));
      const double truth = StaticRms(scene, scene.fundamental, SampsonDistance);
      EXPECT_NEAR(truth, 0.3, 0.03) << "the test's own scene";
      EXPECT_LT(StaticRms(scene, result, SampsonDistance), 1.1 * truth) << seed;
    }
  }
}

TEST(EstimateHomography, FitsAsWellAsTheTruth) {
  for (const CameraMotion motion : {CameraMotion::kRotation, CameraMotion::kPlanar}) {
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      const SyntheticPairs scene = NoisyScene(motion, 0.3, seed);
      const auto result = Value(EstimateHomography(scene.pairs, 1.0, seed));
      EXPECT_LT(StaticRms(scene, result, TransferDistance),
                1.05 * StaticRms(scene, scene.homography, TransferDistance))
          << seed;
    }
  }
}

TEST(Ransac, SameSeedSameBytesForAnyNumberOfThreads) {
  const SyntheticPairs scene = MakeSyntheticPairs({.outlier_share = 0.3});
  const int threads = cv::getNumThreads();
  for (const auto estimate : {EstimateFundamental, EstimateHomography}) {
    cv::setNumThreads(1);
    const auto a = Value(estimate(scene.pairs, 1.0, 1));
    cv::setNumThreads(4);
    cv::theRNG().state = 12345;
    const auto b = Value(estimate(scene.pairs, 1.0, 1));
    EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 9), 0);
    const auto c = Value(estimate(scene.pairs, 1.0, 99));
    EXPECT_NE(std::memcmp(a.data(), c.data(), sizeof(double) * 9), 0) << "the seed has no effect";
  }
  cv::setNumThreads(threads);
}

TEST(Ransac, DegenerateInputsAreErrorsNotCrashes) {
  std::vector<PointPair> on_a_line;
  for (int i = 0; i < 200; ++i) on_a_line.push_back({1.0 * i, 3.0 * i, 1.0 * i + 2, 3.0 * i - 5});
  const std::vector<PointPair> few(3), identical(200, PointPair{1, 2, 3, 4}),
      not_finite(200, PointPair{1, NAN, 3, 4});
  for (const auto estimate : {EstimateFundamental, EstimateHomography}) {
    EXPECT_THAT(estimate(few, 1.0, 1), IsInvalid("3 point pairs"));
    EXPECT_THAT(estimate(not_finite, 1.0, 1), IsInvalid("0 point pairs"));
    for (const auto& pairs : {identical, on_a_line}) {
      EXPECT_THAT(estimate(pairs, 1.0, 1), IsError(absl::StatusCode::kNotFound, "200 point pairs"));
    }
  }
}

TEST(Ransac, PairsThatAreNotFiniteAreLeftOut) {
  SyntheticPairs scene = NoisyScene(CameraMotion::kForward, 0.2, 1);
  const auto expected = Value(EstimateFundamental(scene.pairs, 0.5, 1));
  scene.pairs.insert(scene.pairs.begin(), {{NAN, 1, 2, 3}, {1, 2, INFINITY, 3}});
  EXPECT_EQ(Value(EstimateFundamental(scene.pairs, 0.5, 1)), expected);
}

// Hand-labelled matches of real pictures, AdelaideRMF (Wong, Chin, Yu and Suter, ICCV 2011): label 1
// is the one rigid motion, 0 a false match.
TEST(EstimateFundamental, SeparatesTheMatchesOfRealPictures) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  for (const std::string name : {"biscuit", "book"}) {
    std::ifstream file(std::string(data) + "/adelaide-rmf/" + name + ".csv");
    std::vector<PointPair> pairs;
    std::vector<int> labels;
    for (std::string line; std::getline(file, line);) {
      PointPair p;
      int label = 0;
      if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%d", &p.x1, &p.y1, &p.x2, &p.y2, &label) ==
          5) {
        pairs.push_back(p);
        labels.push_back(label);
      }
    }
    ASSERT_GT(pairs.size(), 100u) << name;
    for (int seed = 1; seed <= 20; ++seed) {
      const auto f = Value(EstimateFundamental(pairs, 1.0, seed));
      double near[2] = {0, 0}, all[2] = {0, 0};
      for (size_t i = 0; i < pairs.size(); ++i) {
        all[labels[i]] += 1.0;
        near[labels[i]] += SampsonDistance(f, pairs[i]) < 2.0;
      }
      EXPECT_GE(near[1], 0.95 * all[1]) << name << " seed " << seed;
      EXPECT_LE(near[0], 0.10 * all[0]) << name << " seed " << seed;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
