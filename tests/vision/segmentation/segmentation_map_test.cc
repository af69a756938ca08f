#include "vision/segmentation/segmentation_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

TEST(ExpectedOverlap, IsThatOfDrawnTruths) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> uniform;
  std::vector<float> probability(20000);
  for (float& p : probability) p = uniform(random) * uniform(random);
  double overlap = 0.0;
  constexpr int kTruths = 20;
  for (int t = 0; t < kTruths; ++t) {
    double both = 0.0, either = 0.0;
    for (const float p : probability) {
      const bool moves = uniform(random)<p, marked = p> 0.5f;
      both += moves && marked;
      either += moves || marked;
    }
    overlap += both / either / kTruths;
  }
  EXPECT_NEAR(ExpectedOverlap(probability), overlap, 0.005);
}

TEST(ExpectedOverlap, OfMapsWithoutAMaskIsTheChanceThatNothingMoves) {
  EXPECT_NEAR(ExpectedOverlap({0.01f, 0.2f, 0.02f}), 0.8, 1e-6);
  EXPECT_TRUE(std::isnan(ExpectedOverlap({})));
}

}  // namespace
}  // namespace egosieve::vision
