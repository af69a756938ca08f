#include "vision/segmentation/nearest_feature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egosieve::vision {
namespace {

TEST(SpreadToGrid, EveryPixelTakesItsNearestFeature) {
  const kernels::ImageGrid grid{83, 41, 5};
  std::mt19937_64 random(1);
  std::vector<double> positions, values;
  for (int i = 0; i < 60; ++i) {
    positions.push_back(static_cast<double>(random() % 8200) / 100.0);
    positions.push_back(static_cast<double>(random() % 4000) / 100.0);
    values.push_back(i);
  }
  const std::vector<float> spread = SpreadToGrid({positions.data(), 60, 2}, values, grid);
  ASSERT_EQ(static_cast<int64_t>(spread.size()), grid.size());
  size_t next = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      size_t best = 0;
      double least = 1e9;
      for (size_t i = 0; i < values.size(); ++i) {
        const double distance = std::hypot(positions[2 * i] - grid.x_pixels(column),
                                           positions[2 * i + 1] - grid.y_pixels(row));
        if (distance < least) {
          least = distance;
          best = i;
        }
      }
      EXPECT_EQ(spread[next++], static_cast<float>(best));
    }
  }
}

TEST(SpreadToGrid, TiesGoToTheFirstAndNothingToTheDefault) {
  const kernels::ImageGrid grid{11, 1, 10};
  const std::vector<double> positions = {5.0, 0.0, 5.0, 0.0};
  EXPECT_EQ(SpreadToGrid({positions.data(), 2, 2}, {3.0, 4.0}, grid),
            (std::vector<float>{3.0f, 3.0f}));
  EXPECT_EQ(SpreadToGrid({nullptr, 0, 2}, {}, grid, 0.25), (std::vector<float>{0.25f, 0.25f}));
}

}  // namespace
}  // namespace egosieve::vision
