#include "kernels/ops/grid_interpolation.h"

#include <cmath>

#include "gtest/gtest.h"
#include "kernels/reference/image.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

// Two interpolations of values in [-1, 1], three roundings each, and the fractions': 8 u.
constexpr double kTolerance = 8.0 / (1 << 24);

TEST(GridInterpolation, AgreesWithTheReferenceAndIsExactAtGridPixels) {
  std::mt19937_64 random = TestRandom();
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 7}, {7, 1}, {6, 11}, {30, 23}, {101, 64}}) {
    for (const int stride : {1, 2, 5, 7, 300}) {
      SCOPED_TRACE(testing::Message() << width << " x " << height << ", stride " << stride);
      const ImageGrid grid = {width, height, stride};
      GuardedMatrix<float> values(grid.rows(), grid.columns(), 1);
      for (int i = 0; i < grid.rows(); ++i) {
        for (int j = 0; j < grid.columns(); ++j)
          values.view()(i, j) = static_cast<float>(Uniform(random, -1, 1));
      }
      GuardedMatrix<float> out(height, width, 3);
      GuardedMatrix<float> expected(height, width);
      ASSERT_EQ(GridInterpolation(*TestContext(), grid, values.view(), out.view()),
                absl::OkStatus());
      EXPECT_TRUE(out.guards_intact());
      GuardedMatrix<float> by_pixel(height, width, 3);
      ASSERT_TRUE(
          GridInterpolation(*SideBySideContext(), grid, values.view(), by_pixel.view()).ok());
      EXPECT_TRUE(by_pixel.guards_intact());
      reference::GridInterpolation(grid, values.view(), expected.view());
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          ASSERT_NEAR(out(y, x), expected(y, x), kTolerance) << x << ", " << y;
          ASSERT_EQ(out(y, x), by_pixel(y, x)) << x << ", " << y;
        }
      }
      for (int i = 0; i < grid.rows(); ++i) {
        for (int j = 0; j < grid.columns(); ++j)
          ASSERT_EQ(out(grid.y_pixels(i), grid.x_pixels(j)), values(i, j));
      }
    }
  }
}

TEST(GridInterpolation, ReproducesALinearMap) {
  const ImageGrid grid = {23, 18, 5};
  GuardedMatrix<float> values(grid.rows(), grid.columns());
  const auto map = [](int x, int y) { return 0.25f * x - 0.5f * y + 3.0f; };
  for (int i = 0; i < grid.rows(); ++i) {
    for (int j = 0; j < grid.columns(); ++j)
      values.view()(i, j) = map(grid.x_pixels(j), grid.y_pixels(i));
  }
  GuardedMatrix<float> out(18, 23);
  ASSERT_TRUE(GridInterpolation(*TestContext(), grid, values.view(), out.view()).ok());
  for (int y = 0; y < 18; ++y) {
    // Values below 9: nine times the tolerance of values in [-1, 1].
    for (int x = 0; x < 23; ++x) ASSERT_NEAR(out(y, x), map(x, y), 9 * kTolerance);
  }
}

TEST(GridInterpolation, BadArgumentsAreNamedAndNothingIsWritten) {
  const ImageGrid grid = {23, 18, 5};
  GuardedMatrix<float> values(grid.rows(), grid.columns());
  GuardedMatrix<float> out(18, 23);
  EXPECT_FALSE(GridInterpolation(*TestContext(), {23, 18, 0}, values.view(), out.view()).ok());
  EXPECT_FALSE(GridInterpolation(*TestContext(), {24, 18, 1}, values.view(), out.view()).ok());
  values.view()(2, 3) = NAN;
  EXPECT_THAT(GridInterpolation(*TestContext(), grid, values.view(), out.view()),
              IsInvalid("values(2, 3)"));
  EXPECT_TRUE(out.untouched());
}

}  // namespace
}  // namespace egosieve::kernels
