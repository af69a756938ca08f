#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

TEST(DensestWindow, HoldsTheMostValues) {
  const ValueWindow window = DensestWindow({0.0, 1.0, 3.0, 3.25, 3.5, 4.0, 9.0}, 1.0);
  EXPECT_EQ(window.first, 2u);
  EXPECT_EQ(window.count, 4u);  // 3 to 4: its width is included
}

TEST(DensestWindow, IsTheFirstOfSeveral) {
  const ValueWindow window = DensestWindow({0.0, 0.5, 2.0, 2.5, 8.0}, 1.0);
  EXPECT_EQ(window.first, 0u);
  EXPECT_EQ(window.count, 2u);
}

TEST(DensestWindow, OfOneOrNoValue) {
  EXPECT_EQ(DensestWindow({5.0}, 0.1).count, 1u);
  EXPECT_EQ(DensestWindow({}, 0.1).count, 0u);
}

TEST(Median, IsTheMiddleOfSortedValuesTheUpperOfTwo) {
  EXPECT_EQ(Median(std::vector<double>{7.0}), 7.0);
  EXPECT_EQ(Median(std::vector<double>{5.0, -1.0, 3.0}), 3.0);
  EXPECT_EQ(Median(std::vector<float>{4.0f, 1.0f, 3.0f, 2.0f}), 3.0f);
  std::vector<int> values = {9, 9, 1, 8, 2};
  EXPECT_EQ(MedianInPlace(values), 8);
}

TEST(OfRankInPlace, IsTheValueAtThisPlaceOfTheSortedOnes) {
  std::vector<int> values = {5, 3, 9, 3, 1, 7, 2, 8, 3};
  std::vector<int> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (size_t rank = 0; rank < sorted.size(); ++rank) {
    EXPECT_EQ(OfRankInPlace(values, rank), sorted[rank]) << rank;
  }
}

TEST(QuantileInPlace, IsOneOfTheValuesFromTheLeastToTheGreatest) {
  std::vector<uint8_t> values = {40, 10, 50, 20, 30};
  EXPECT_EQ(QuantileInPlace(values, 0.0), 10);
  EXPECT_EQ(QuantileInPlace(values, 0.49), 20);  // place 1.96
  EXPECT_EQ(QuantileInPlace(values, 0.5), 30);
  EXPECT_EQ(QuantileInPlace(values, 0.99), 40);
  EXPECT_EQ(QuantileInPlace(values, 1.0), 50);
  std::vector<uint8_t> single = {6};
  EXPECT_EQ(QuantileInPlace(single, 0.7), 6);
}

TEST(MadToDeviation, PutsHalfOfAGaussianWithinTheMedian) {
  // P(|x| < q) of N(0, 1). Its slope at q = 0.6745 is 2 phi(q) = 0.636, and five digits leave a
  // relative error of q of at most 5e-5 / 1.4826: 0.636 * 0.6745 * 3.4e-5 < 1.5e-5.
  EXPECT_NEAR(std::erf(1.0 / (kMadToDeviation * std::sqrt(2.0))), 0.5, 1.5e-5);
}

TEST(RobustScale, IsTheMedianTimesTheConstantAndNotBelowItsFloor) {
  EXPECT_EQ(RobustScale(std::vector<double>{3.0, 1.0, 2.0}, 0.2), 1.4826 * 2.0);
  EXPECT_EQ(RobustScale(std::vector<int>{5, 100, 5}, 0.2), 1.4826 * 5);
  EXPECT_EQ(RobustScale(std::vector<double>{0.0, 0.0, 9.0}, 0.2), 0.2);
  EXPECT_EQ(RobustScale(std::vector<double>{}, 0.2), 0.2);
}

TEST(RobustScale, IsTheStandardDeviationOfAGaussian) {
  std::mt19937_64 engine(1);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::vector<double> distances;
  for (int i = 0; i < 20001; ++i) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    distances.push_back(0.7 * std::abs(radius * std::cos(2.0 * M_PI * uniform())));
  }
  // The sample median of 20001 has a relative standard error of 1.17 / sqrt(20001) = 0.8 %.
  EXPECT_NEAR(RobustScale(distances, 0.2), 0.7, 3 * 0.008 * 0.7);
}

}  // namespace
}  // namespace egosieve::vision
