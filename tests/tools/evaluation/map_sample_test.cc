#include "tools/evaluation/map_sample.h"

#include <gtest/gtest.h>

#include <utility>

namespace egosieve::tools {
namespace {

// On a grid of stride 5 over 12 x 9 pixels the last column lies at 11, one pixel behind 10.
TEST(InterpolateAt, IsLinearInEachCellAndExactAtGridPixels) {
  const kernels::ImageGrid grid{12, 9, 5};
  cv::Mat1f map(grid.rows(), grid.columns());
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.cols; ++column) {
      map(row, column) = static_cast<float>(grid.x_pixels(column) + 100 * grid.y_pixels(row));
    }
  }
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {11.0, 8.0}, {10.25, 3.5}, {4.75, 7.5}}) {
    EXPECT_NEAR(InterpolateAt(map, grid, x, y), x + 100 * y, 1e-9) << x << ", " << y;
  }
}

}  // namespace
}  // namespace egosieve::tools
