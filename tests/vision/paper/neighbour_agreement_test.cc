#include "vision/paper/neighbour_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

// Two motions side by side and false matches among them.
TEST(AgreesWithNeighbours, KeepsWorldAndMoverAndDropsFalseMatches) {
  std::mt19937_64 engine(5);
  const auto uniform = [&](double most) {
    return most * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  std::vector<PointPair> pairs;
  std::vector<bool> is_false;
  for (int i = 0; i < 2000; ++i) {
    const double x = uniform(800), y = uniform(300);
    const bool mover = x > 300 && x < 420 && y > 100 && y < 200;
    PointPair pair{x, y, x + (mover ? -25 : 4) + uniform(1), y + 2 + uniform(1)};
    is_false.push_back(i % 10 == 0);
    if (is_false.back()) {
      pair.x2 = uniform(800);
      pair.y2 = uniform(300);
    }
    pairs.push_back(pair);
  }
  const std::vector<uint8_t> agrees = AgreesWithNeighbours(pairs, {});
  int kept_false = 0, dropped_true = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    kept_false += is_false[i] && agrees[i] != 0;
    dropped_true += !is_false[i] && agrees[i] == 0;
  }
  // About 42 neighbours each, 4 of them false and so to within about 15 pixels in 240,000 square
  // pixels.
  EXPECT_LE(kept_false, 10) << "of 200";
  EXPECT_LE(dropped_true, 5) << "of 1800";
}

TEST(AgreesWithNeighbours, FewAndWildPairs) {
  EXPECT_TRUE(AgreesWithNeighbours({}, {}).empty());
  EXPECT_EQ(AgreesWithNeighbours({{1, 1, 2, 2}}, {}), std::vector<uint8_t>({0}));
  NeighbourAgreementOptions alone;
  alone.minimum_neighbours = 0;
  EXPECT_EQ(AgreesWithNeighbours({{1, 1, 2, 2}, {NAN, 1, 2, 2}, {1e300, 1, 2, 2}}, alone),
            std::vector<uint8_t>({1, 0, 0}));
  // Across the origin, where cells change sign.
  NeighbourAgreementOptions one;
  one.minimum_neighbours = 1;
  EXPECT_EQ(AgreesWithNeighbours({{-1, -1, 0, 0}, {1, 1, 2, 2}}, one),
            std::vector<uint8_t>({1, 1}));
}

}  // namespace
}  // namespace egosieve::vision
