#include "kernels/reference/image.h"

#include <cmath>
#include <vector>

#include "kernels/ops/box_means.h"
#include "kernels/ops/grid_interpolation.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

struct TestImage {
  std::vector<uint8_t> pixels;
  ImageView view;
};

TestImage RandomImage(std::mt19937_64& random, int width, int height, int channels, int padding) {
  TestImage image;
  image.view.stride_bytes = width * channels + padding;
  image.pixels.resize(height * image.view.stride_bytes);
  for (uint8_t& pixel : image.pixels) pixel = static_cast<uint8_t>(random());
  image.view = {image.pixels.data(), width, height, channels, image.view.stride_bytes};
  return image;
}

// Intensities in [-1, 1] come from exact integer sums by three roundings, M by three more; u and v
// by one of float64 values: 8 u with u = 2^-24.
constexpr double kTolerance = 8.0 / (1 << 24);

void ExpectFieldMatchesReference(const ImageView& image, int stride, int window) {
  const ImageGrid grid = {image.width, image.height, stride};
  const BoxMeanOptions options{.window_pixels = window};
  GuardedMatrix<float> field(grid.size(), kBoxMeanColumns, 2);
  ASSERT_EQ(BoxMeansOnGrid(*TestContext(), image, grid, options, field.view()), absl::OkStatus());
  EXPECT_TRUE(field.guards_intact());
  GuardedMatrix<float> by_point(grid.size(), kBoxMeanColumns, 2);
  ASSERT_TRUE(BoxMeansOnGrid(*SideBySideContext(), image, grid, options, by_point.view()).ok());
  EXPECT_TRUE(by_point.guards_intact());
  GuardedMatrix<float> expected(grid.size(), kBoxMeanColumns);
  reference::BoxMeansOnGrid(image, grid, window, expected.view());
  std::vector<double> points;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      points.push_back(grid.x_pixels(column));
      points.push_back(grid.y_pixels(row));
    }
  }
  GuardedMatrix<float> at(grid.size(), kBoxMeanColumns);
  const ConstMatrixView<double> view(points.data(), grid.size(), 2);
  ASSERT_TRUE(BoxMeansAt(*TestContext(), image, view, options, at.view()).ok());
  EXPECT_TRUE(at.guards_intact());
  for (int64_t i = 0; i < grid.size(); ++i) {
    for (int d = 0; d < kBoxMeanColumns; ++d) {
      ASSERT_NEAR(field(i, d), expected(i, d), kTolerance) << "grid point " << i << ", input " << d;
      ASSERT_EQ(field(i, d), at(i, d)) << "grid point " << i << ", input " << d;
      ASSERT_EQ(field(i, d), by_point(i, d)) << "grid point " << i << ", input " << d;
    }
  }
}

TEST(BoxMeansOnGrid, AgreesWithTheReferenceForEveryShape) {
  std::mt19937_64 random = TestRandom();
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 9}, {9, 1}, {3, 2}, {16, 16}, {17, 33}, {130, 77}}) {
    for (const int channels : {1, 3}) {
      const TestImage image = RandomImage(random, width, height, channels, 5);
      for (const int stride : {1, 2, 5, 200}) {
        for (const int window : {1, 3, 7, 301}) {
          SCOPED_TRACE(testing::Message() << width << " x " << height << " x " << channels
                                          << ", stride " << stride << ", window " << window);
          ExpectFieldMatchesReference(image.view, stride, window);
        }
      }
    }
  }
}

TEST(BoxMeansOnGrid, AnEvenImageHasItsOwnColour) {
  std::vector<uint8_t> pixels;
  for (int i = 0; i < 20 * 10; ++i) pixels.insert(pixels.end(), {0, 51, 255});  // B, G, R
  const ImageView image = {pixels.data(), 20, 10, 3, 60};
  const ImageGrid grid = {20, 10, 5};
  GuardedMatrix<float> field(grid.size(), 6);
  ASSERT_TRUE(BoxMeansOnGrid(*TestContext(), image, grid, {}, field.view()).ok());
  // The first point is the upper left pixel, the last the lower right one; v spans 9/19 of u.
  EXPECT_NEAR(field(0, 0), -1.0, kTolerance);
  EXPECT_NEAR(field(0, 1), -9.0 / 19.0, kTolerance);
  EXPECT_NEAR(field(grid.size() - 1, 0), 1.0, kTolerance);
  EXPECT_NEAR(field(grid.size() - 1, 1), 9.0 / 19.0, kTolerance);
  for (int64_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(field(i, 2), 0.299 * 1.0 + 0.587 * -0.6 + 0.114 * -1.0, kTolerance);
    EXPECT_NEAR(field(i, 3), 1.0, kTolerance);
    EXPECT_NEAR(field(i, 4), -0.6, kTolerance);
    EXPECT_NEAR(field(i, 5), -1.0, kTolerance);
  }
}

TEST(BoxMeansAt, PointsBetweenPixelsTakeTheNearestWindowAndKeepTheirPlace) {
  std::mt19937_64 random = TestRandom();
  const TestImage image = RandomImage(random, 30, 20, 3, 0);
  const double points[] = {7.4, 11.6, 7.0, 12.0, -0.5, 19.5, 0.0, 19.0};
  GuardedMatrix<float> out(4, 6);
  ASSERT_TRUE(BoxMeansAt(*TestContext(), image.view, {points, 4, 2}, {}, out.view()).ok());
  for (int d = 2; d < 6; ++d) {
    EXPECT_EQ(out(0, d), out(1, d));
    EXPECT_EQ(out(2, d), out(3, d));
  }
  EXPECT_TRUE(out.guards_intact());
  GuardedMatrix<float> none(0, 6);
  EXPECT_TRUE(BoxMeansAt(*TestContext(), image.view, {points, 0, 2}, {}, none.view()).ok());
  EXPECT_TRUE(none.untouched());
  EXPECT_NEAR(out(0, 0), (2 * 7.4 - 29) / 29, kTolerance);
  EXPECT_NEAR(out(0, 1), (2 * 11.6 - 19) / 29, kTolerance);
}

TEST(BoxMeansOnGrid, BadArgumentsAreNamedAndNothingIsWritten) {
  std::mt19937_64 random = TestRandom();
  const TestImage image = RandomImage(random, 30, 20, 3, 0);
  const ImageGrid grid = {30, 20, 5};
  GuardedMatrix<float> out(grid.size(), 6);
  const auto message_of = [&](const ImageView& view, const ImageGrid& at,
                              const BoxMeanOptions& options) {
    const absl::Status status = BoxMeansOnGrid(*TestContext(), view, at, options, out.view());
    EXPECT_THAT(status, IsInvalid());
    EXPECT_TRUE(out.untouched());
    return std::string(status.message());
  };
  for (const int window : {0, -1, 6}) {
    const BoxMeanOptions options{.window_pixels = window};
    EXPECT_THAT(message_of(image.view, grid, options), testing::HasSubstr("window_pixels"));
  }
  EXPECT_THAT(message_of(image.view, {30, 20, 0}, {}), testing::HasSubstr("stride"));
  EXPECT_THAT(message_of(image.view, {31, 20, 5}, {}), testing::HasSubstr("31 x 20"));
  ImageView bad = image.view;
  bad.channels = 4;
  EXPECT_THAT(message_of(bad, grid, {}), testing::HasSubstr("channels = 4"));
  bad = image.view;
  bad.stride_bytes = 89;
  EXPECT_THAT(message_of(bad, grid, {}), testing::HasSubstr("stride_bytes = 89"));
  bad = image.view;
  bad.data = nullptr;
  EXPECT_THAT(message_of(bad, grid, {}), testing::HasSubstr("without data"));
  for (const double coordinate : {-0.6, 29.6, static_cast<double>(NAN)}) {
    const double point[] = {coordinate, 3.0};
    GuardedMatrix<float> one(1, 6);
    EXPECT_THAT(BoxMeansAt(*TestContext(), image.view, {point, 1, 2}, {}, one.view()), IsInvalid());
    EXPECT_TRUE(one.untouched());
  }
}

// The tolerance: two interpolations of values in [-1, 1], three roundings each, and the fractions'.
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
