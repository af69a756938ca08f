#include "vision/paper/fundamental_fit.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/vision/geometry/synthetic_pairs.h"

namespace egosieve::vision {
namespace {

using testing::CameraMotion;
using testing::MakeSyntheticPairs;
using testing::SyntheticPairs;

// Root mean square residual over the static pairs.
double StaticRms(const SyntheticPairs& scene, const Eigen::Matrix3d& matrix) {
  double sum = 0.0, n = 0.0;
  for (size_t i = 0; i < scene.pairs.size(); ++i) {
    if (scene.is_mover[i]) continue;
    const double d = SampsonDistance(matrix, scene.pairs[i]);
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

TEST(FitFundamental, FitsTheStaticWorldAsWellAsTheTruth) {
  for (const CameraMotion motion : {CameraMotion::kForward, CameraMotion::kSideways}) {
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      const SyntheticPairs scene = NoisyScene(motion, 0.2, seed);
      const MotionModel model = FitFundamental(scene.pairs, seed);
      EXPECT_EQ(model.kind, MotionModelKind::kFundamental);
      EXPECT_TRUE(model.trusted);
      const double truth = StaticRms(scene, scene.fundamental);
      EXPECT_NEAR(truth, 0.3, 0.03) << "the test's own scene";
      EXPECT_LT(StaticRms(scene, model.matrix), 1.1 * truth) << seed;
    }
  }
}

TEST(FitFundamental, SameSeedSameBytesForAnyNumberOfThreads) {
  const SyntheticPairs scene = MakeSyntheticPairs({.outlier_share = 0.3});
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const MotionModel a = FitFundamental(scene.pairs, 1);
  cv::setNumThreads(4);
  cv::theRNG().state = 12345;
  EXPECT_EQ(FitFundamental(scene.pairs, 1).matrix, a.matrix);
  EXPECT_NE(FitFundamental(scene.pairs, 99).matrix, a.matrix) << "the seed has no effect";
  cv::setNumThreads(threads);
}

TEST(FitFundamental, FewAndDegeneratePairsGiveAReason) {
  std::vector<PointPair> on_a_line;
  for (int i = 0; i < 200; ++i) on_a_line.push_back({1.0 * i, 3.0 * i, 1.0 * i + 2, 3.0 * i - 5});
  const std::vector<PointPair> few(3), identical(200, PointPair{1, 2, 3, 4}),
      not_finite(200, PointPair{1, NAN, 3, 4});
  for (const auto& [pairs, reason] :
       {std::pair(few, "3 point pairs"), std::pair(not_finite, "0 point pairs"),
        std::pair(identical, "200 point pairs"), std::pair(on_a_line, "200 point pairs")}) {
    const MotionModel model = FitFundamental(pairs, 1);
    EXPECT_EQ(model.kind, MotionModelKind::kNone);
    EXPECT_FALSE(model.trusted);
    EXPECT_THAT(model.reason, ::testing::HasSubstr(reason));
  }
}

TEST(FitFundamental, PairsThatAreNotFiniteAreLeftOut) {
  SyntheticPairs scene = NoisyScene(CameraMotion::kForward, 0.2, 1);
  const MotionModel expected = FitFundamental(scene.pairs, 1);
  scene.pairs.insert(scene.pairs.begin(), {{NAN, 1, 2, 3}, {1, 2, INFINITY, 3}});
  EXPECT_EQ(FitFundamental(scene.pairs, 1).matrix, expected.matrix);
}

TEST(FitFundamental, NoMajorityIsNotTrusted) {
  const auto scene = MakeSyntheticPairs({.mover_share = 0.0, .outlier_share = 0.95});
  const MotionModel model = FitFundamental(scene.pairs, 1);
  EXPECT_FALSE(model.trusted);
  EXPECT_EQ(model.reason,
            absl::StrFormat("only %.0f %% of the matches agree on one motion of the camera",
                            100.0 * model.inlier_count / scene.pairs.size()));
}

// Hand-labelled matches of real pictures, AdelaideRMF (Wong, Chin, Yu and Suter, ICCV 2011): label 1
// is the one rigid motion, 0 a false match.
TEST(FitFundamental, SeparatesTheMatchesOfRealPictures) {
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
      const Eigen::Matrix3d f = FitFundamental(pairs, seed).matrix;
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
