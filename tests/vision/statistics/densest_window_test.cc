#include "vision/statistics/densest_window.h"

#include "gtest/gtest.h"

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

}  // namespace
}  // namespace egosieve::vision
