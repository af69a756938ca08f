#include "vision/image/box_means.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

// Bands of grid rows, each with sums of its own.
constexpr int kMostBands = 64;

absl::Status CheckPlaces(const ImageView& image, kernels::ConstMatrixView<double> points) {
  for (int64_t i = 0; i < points.rows; ++i) {
    const double x = points(i, 0), y = points(i, 1);
    if (!(x >= -0.5 && x <= image.width - 0.5 && y >= -0.5 && y <= image.height - 0.5)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("points row %d = (%g, %g) is outside the image of %d x %d", i, x, y,
                          image.width, image.height));
    }
  }
  return absl::OkStatus();
}

// Pixels begin to end - 1 along an axis.
struct Span {
  int begin, end;
  int size() const { return end - begin; }
};

Span WindowAround(int pixel, int radius, int size) {
  return {std::max(pixel - radius, 0), std::min(pixel + radius + 1, size)};
}

int NearestPixel(double coordinate, int size) {
  return std::clamp(static_cast<int>(std::floor(coordinate + 0.5)), 0, size - 1);
}

// The row of `out` for a window of `count` pixels whose channels have these sums. Both functions use
// it, so that they agree bit for bit.
void WriteMeans(double u, double v, const int32_t* sums, int channels, int64_t count, float* out) {
  const float scale = 2.0f / (255.0f * static_cast<float>(count));
  const auto mean = [&](int channel) {
    return std::fma(static_cast<float>(sums[channel]), scale, -1.0f);
  };
  const float m0 = mean(0), m1 = mean(channels / 2), m2 = mean(channels - 1);
  out[0] = static_cast<float>(u);
  out[1] = static_cast<float>(v);
  out[2] = channels == 1 ? m0 : std::fma(0.299f, m2, std::fma(0.587f, m1, 0.114f * m0));
  out[3] = m2;
  out[4] = m1;
  out[5] = m0;
}

void AddRow(const uint8_t* row, int64_t size, int sign, uint32_t* sums) {
  for (int64_t i = 0; i < size; ++i) sums[i] += sign * row[i];
}

}  // namespace

ImageView ViewOf(const cv::Mat& picture) {
  return {picture.data, picture.cols, picture.rows, picture.channels(),
          static_cast<ptrdiff_t>(picture.step[0])};
}

std::vector<float> BoxMeansOnGrid(const ImageView& image, const ImageGrid& grid,
                                  int window_pixels) {
  std::vector<float> out(grid.size() * kBoxMeanColumns);
  const PixelNormalization map = NormalizationForImage(image.width, image.height);
  const int radius = window_pixels / 2, channels = image.channels;
  const int rows = grid.rows(), columns = grid.columns();
  const int64_t size = int64_t{image.width} * channels;
  const int rows_per_band = (rows + kMostBands - 1) / kMostBands;
  const int bands = (rows + rows_per_band - 1) / rows_per_band;
  kernels::ParallelFor(bands, 4.0 * size * image.height + 20.0 * grid.size(), [&](int64_t band) {
    // Of each column of bytes over the window's rows, which slide from one grid row to the next;
    // and of these along the row. The latter may overflow: only their differences count.
    std::vector<uint32_t> sums(size), running(size + channels);
    Span in_sums = {0, 0};
    const int first = static_cast<int>(band) * rows_per_band;
    for (int row = first; row < std::min(first + rows_per_band, rows); ++row) {
      const int y = grid.y_pixels(row);
      const Span down = WindowAround(y, radius, image.height);
      if (down.begin >= in_sums.end || down.begin - in_sums.begin >= down.size()) {
        std::fill(sums.begin(), sums.end(), 0);
        in_sums = {down.begin, down.begin};
      }
      for (; in_sums.end < down.end; ++in_sums.end) {
        AddRow(image.data + in_sums.end * image.stride_bytes, size, 1, sums.data());
      }
      for (; in_sums.begin < down.begin; ++in_sums.begin) {
        AddRow(image.data + in_sums.begin * image.stride_bytes, size, -1, sums.data());
      }
      for (int64_t i = 0; i < size; ++i) running[i + channels] = running[i] + sums[i];
      for (int column = 0; column < columns; ++column) {
        const int x = grid.x_pixels(column);
        const Span across = WindowAround(x, radius, image.width);
        int32_t totals[3];
        for (int c = 0; c < channels; ++c) {
          totals[c] = static_cast<int32_t>(running[int64_t{across.end} * channels + c] -
                                           running[int64_t{across.begin} * channels + c]);
        }
        WriteMeans(x * map.scale + map.u_offset, y * map.scale + map.v_offset, totals, channels,
                   int64_t{across.size()} * down.size(),
                   &out[(int64_t{row} * columns + column) * kBoxMeanColumns]);
      }
    }
  });
  return out;
}

absl::StatusOr<std::vector<float>> BoxMeansAt(const ImageView& image,
                                              kernels::ConstMatrixView<double> points,
                                              int window_pixels) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPlaces(image, points));
  std::vector<float> out(points.rows * kBoxMeanColumns);
  const PixelNormalization map = NormalizationForImage(image.width, image.height);
  const int radius = window_pixels / 2, channels = image.channels;
  for (int64_t i = 0; i < points.rows; ++i) {
    const double x = points(i, 0), y = points(i, 1);
    const Span across = WindowAround(NearestPixel(x, image.width), radius, image.width);
    const Span down = WindowAround(NearestPixel(y, image.height), radius, image.height);
    int32_t sums[3] = {};
    for (int row = down.begin; row < down.end; ++row) {
      const uint8_t* pixels = image.data + row * image.stride_bytes;
      for (int column = across.begin; column < across.end; ++column) {
        for (int c = 0; c < channels; ++c) sums[c] += pixels[column * channels + c];
      }
    }
    WriteMeans(x * map.scale + map.u_offset, y * map.scale + map.v_offset, sums, channels,
               int64_t{across.size()} * down.size(), &out[i * kBoxMeanColumns]);
  }
  return out;
}

}  // namespace egosieve::vision
