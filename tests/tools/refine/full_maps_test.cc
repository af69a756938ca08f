#include "tools/refine/full_maps.h"

#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::tools {
namespace {

TEST(InterpolateMap, IsExactForLinearMaps) {
  const std::shared_ptr<kernels::Context> context = Value(kernels::OpenContext({}));
  const kernels::ImageGrid grid{43, 29, 5};  // the last cells are narrower
  const auto plane = [](double x, double y) { return 0.1 + 0.013 * x + 0.007 * y; };
  cv::Mat1f values(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      values(row, column) = static_cast<float>(plane(grid.x_pixels(column), grid.y_pixels(row)));
    }
  }
  const cv::Mat1f full = Value(InterpolateMap(*context, grid, values));
  ASSERT_EQ(full.size(), cv::Size(43, 29));
  for (int y = 0; y < 29; ++y) {
    for (int x = 0; x < 43; ++x) {
      // Four products and sums of floats below 1: a few units in the last place, 6e-8 each.
      ASSERT_NEAR(full(y, x), plane(x, y), 5e-7) << x << ", " << y;
    }
  }
}

TEST(ClassifyMap, HasThreeClasses) {
  const cv::Mat1f probability = (cv::Mat1f(1, 5) << 0.0f, 0.39f, 0.5f, 0.75f, 0.76f);
  const cv::Mat1b classes = ClassifyMap(probability, {0.4, 0.75});
  const cv::Mat1b expected = (cv::Mat1b(1, 5) << 0, 0, 128, 128, 255);
  EXPECT_EQ(cv::norm(classes, expected, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace egosieve::tools
