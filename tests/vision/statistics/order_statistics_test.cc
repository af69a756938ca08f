#include "vision/statistics/order_statistics.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

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

TEST(InterpolatedMedian, IsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(InterpolatedMedian({7.0}), 7.0);
  EXPECT_EQ(InterpolatedMedian({8.0, 1.0}), 4.5);
  EXPECT_EQ(InterpolatedMedian({5.0, -1.0, 3.0}), 3.0);
  EXPECT_EQ(InterpolatedMedian({4.0, 1.0, 16.0, 2.0}), 3.0);
}

}  // namespace
}  // namespace egosieve::vision
