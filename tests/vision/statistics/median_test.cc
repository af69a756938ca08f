#include "vision/statistics/median.h"

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

}  // namespace
}  // namespace egosieve::vision
