#include "vision/image/box_means.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"
#include "vision/image/grid_interpolation.h"

namespace egosieve::vision {
namespace {

using kernels::ConstMatrixView;
using kernels::GuardedMatrix;
using kernels::TestRandom;
using kernels::Uniform;

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

// Column d of the box means around the pixel (x, y) in float64.
double ExpectedMean(const ImageView& image, int x, int y, int window, int d) {
  const double extent = std::max(std::max(image.width, image.height) - 1, 1);
  if (d == 0) return (2.0 * x - (image.width - 1)) / extent;
  if (d == 1) return (2.0 * y - (image.height - 1)) / extent;
  if (d == 2) {
    return 0.299 * ExpectedMean(image, x, y, window, 3) +
           0.587 * ExpectedMean(image, x, y, window, 4) +
           0.114 * ExpectedMean(image, x, y, window, 5);
  }
  const int channel = image.channels == 1 ? 0 : 5 - d;
  double sum = 0.0, count = 0.0;
  for (int row = std::max(y - window / 2, 0); row <= std::min(y + window / 2, image.height - 1);
       ++row) {
    for (int column = std::max(x - window / 2, 0);
         column <= std::min(x + window / 2, image.width - 1); ++column) {
      sum += image.data[row * image.stride_bytes + column * image.channels + channel];
      ++count;
    }
  }
  return 2.0 * sum / (255.0 * count) - 1.0;
}

void ExpectFieldIsThatOfTheFormulas(const ImageView& image, int stride, int window) {
  const ImageGrid grid = {image.width, image.height, stride};
  const std::vector<float> field = BoxMeansOnGrid(image, grid, window);
  ASSERT_EQ(field.size(), static_cast<size_t>(grid.size() * kBoxMeanColumns));
  std::vector<double> points;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      points.push_back(grid.x_pixels(column));
      points.push_back(grid.y_pixels(row));
    }
  }
  const ConstMatrixView<double> view(points.data(), grid.size(), 2);
  const std::vector<float> at = Value(BoxMeansAt(image, view, window));
  ASSERT_EQ(field, at);
  for (int64_t i = 0; i < grid.size(); ++i) {
    const int x = static_cast<int>(points[2 * i]), y = static_cast<int>(points[2 * i + 1]);
    for (int d = 0; d < kBoxMeanColumns; ++d) {
      ASSERT_NEAR(field[i * kBoxMeanColumns + d], ExpectedMean(image, x, y, window, d), kTolerance)
          << "grid point " << i << ", input " << d;
    }
  }
}

TEST(BoxMeansOnGrid, FollowsTheFormulasForEveryShape) {
  std::mt19937_64 random = TestRandom();
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 9}, {9, 1}, {3, 2}, {16, 16}, {17, 33}, {130, 77}}) {
    for (const int channels : {1, 3}) {
      const TestImage image = RandomImage(random, width, height, channels, 5);
      for (const int stride : {1, 2, 5, 200}) {
        for (const int window : {1, 3, 7, 301}) {
          SCOPED_TRACE(testing::Message() << width << " x " << height << " x " << channels
                                          << ", stride " << stride << ", window " << window);
          ExpectFieldIsThatOfTheFormulas(image.view, stride, window);
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
  const std::vector<float> means = BoxMeansOnGrid(image, grid);
  const ConstMatrixView<float> field(means.data(), grid.size(), 6);
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
  const std::vector<float> means = Value(BoxMeansAt(image.view, {points, 4, 2}));
  const ConstMatrixView<float> out(means.data(), 4, 6);
  for (int d = 2; d < 6; ++d) {
    EXPECT_EQ(out(0, d), out(1, d));
    EXPECT_EQ(out(2, d), out(3, d));
  }
  EXPECT_TRUE(Value(BoxMeansAt(image.view, {points, 0, 2})).empty());
  EXPECT_NEAR(out(0, 0), (2 * 7.4 - 29) / 29, kTolerance);
  EXPECT_NEAR(out(0, 1), (2 * 11.6 - 19) / 29, kTolerance);
}

TEST(BoxMeansAt, PlacesOutsideAreRefused) {
  std::mt19937_64 random = TestRandom();
  const TestImage image = RandomImage(random, 30, 20, 3, 0);
  for (const double coordinate : {-0.6, 29.6, static_cast<double>(NAN)}) {
    const double point[] = {coordinate, 3.0};
    EXPECT_THAT(BoxMeansAt(image.view, {point, 1, 2}), IsInvalid());
  }
}

// A cut-out shares its parent's rows: the stride must be honoured.
TEST(BoxMeansAt, ViewsIntoLargerPictures) {
  cv::Mat3b whole(40, 60);
  cv::randu(whole, 0, 256);
  const cv::Mat part = whole(cv::Rect(10, 5, 30, 20)), copy = part.clone();
  const double place[] = {14.0, 9.0};
  EXPECT_EQ(*BoxMeansAt(ViewOf(part), {place, 1, 2}), *BoxMeansAt(ViewOf(copy), {place, 1, 2}));
}

// The tolerance: two interpolations of values in [-1, 1], three roundings each, and the fractions'.
TEST(GridInterpolation, IsLinearInEveryCellAndExactAtGridPixels) {
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
      ASSERT_EQ(GridInterpolation(grid, values.view(), out.view()), absl::OkStatus());
      EXPECT_TRUE(out.guards_intact());
      // The place of pixel p among the grid's of an axis, and its share of the way to the next.
      const auto place = [&](int p, int size) {
        const int i = std::min(p / stride, std::max((size - 2) / stride, 0));
        const int first = i * stride, next = std::min(first + stride, size - 1);
        return std::pair(i, next > first ? (p - first) / static_cast<double>(next - first) : 0.0);
      };
      for (int y = 0; y < height; ++y) {
        const auto [i, down] = place(y, height);
        const int below = std::min(i + 1, grid.rows() - 1);
        for (int x = 0; x < width; ++x) {
          const auto [j, across] = place(x, width);
          const int right = std::min(j + 1, grid.columns() - 1);
          const double upper = (1.0 - across) * values(i, j) + across * values(i, right);
          const double lower = (1.0 - across) * values(below, j) + across * values(below, right);
          ASSERT_NEAR(out(y, x), (1.0 - down) * upper + down * lower, kTolerance) << x << ", " << y;
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
  ASSERT_TRUE(GridInterpolation(grid, values.view(), out.view()).ok());
  for (int y = 0; y < 18; ++y) {
    // Values below 9: nine times the tolerance of values in [-1, 1].
    for (int x = 0; x < 23; ++x) ASSERT_NEAR(out(y, x), map(x, y), 9 * kTolerance);
  }
}

TEST(GridInterpolation, BadArgumentsAreNamedAndNothingIsWritten) {
  const ImageGrid grid = {23, 18, 5};
  GuardedMatrix<float> values(grid.rows(), grid.columns());
  GuardedMatrix<float> out(18, 23);
  EXPECT_FALSE(GridInterpolation({23, 18, 0}, values.view(), out.view()).ok());
  EXPECT_FALSE(GridInterpolation({24, 18, 1}, values.view(), out.view()).ok());
  values.view()(2, 3) = NAN;
  EXPECT_THAT(GridInterpolation(grid, values.view(), out.view()), IsInvalid("values(2, 3)"));
  EXPECT_TRUE(out.untouched());
}

TEST(ImageGrid, ItsLastRowAndColumnLieOnTheBorder) {
  for (const int width : {1, 2, 5, 6, 7, 640}) {
    for (const int stride : {1, 2, 5, 6, 1000}) {
      const ImageGrid grid = {width, 3, stride};
      ASSERT_TRUE(grid.Validate().ok());
      EXPECT_EQ(grid.x_pixels(0), 0);
      EXPECT_EQ(grid.x_pixels(grid.columns() - 1), width - 1);
      for (int c = 1; c < grid.columns(); ++c) {
        EXPECT_GT(grid.x_pixels(c), grid.x_pixels(c - 1));
        EXPECT_LE(grid.x_pixels(c) - grid.x_pixels(c - 1), stride);
      }
      EXPECT_EQ(grid.size(), static_cast<int64_t>(grid.columns()) * grid.rows());
    }
  }
}

TEST(ImageGrid, BadSizesAreNamed) {
  EXPECT_THAT(ImageGrid({0, 5, 1}).Validate().message(), testing::HasSubstr("0 x 5"));
  EXPECT_THAT(ImageGrid({5, 5, 0}).Validate().message(), testing::HasSubstr("stride = 0"));
}

TEST(NormalizationForImage, TheLongerSideSpansMinusOneToOne) {
  const PixelNormalization wide = NormalizationForImage(641, 481);
  EXPECT_DOUBLE_EQ(0 * wide.scale + wide.u_offset, -1.0);
  EXPECT_DOUBLE_EQ(640 * wide.scale + wide.u_offset, 1.0);
  EXPECT_DOUBLE_EQ(480 * wide.scale + wide.v_offset, 0.75);
  const PixelNormalization single = NormalizationForImage(1, 1);
  EXPECT_EQ(single.u_offset, 0.0);
  EXPECT_EQ(single.v_offset, 0.0);
}

}  // namespace
}  // namespace egosieve::vision
