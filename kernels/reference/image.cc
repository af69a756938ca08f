#include "kernels/reference/image.h"

#include <algorithm>
#include <cmath>

namespace egosieve::kernels::reference {
namespace {

// Writes the row of `out` for the window around the pixel (x, y); u and v are the point's own.
void MeansAround(const ImageView& image, int x, int y, int window_pixels, double u, double v,
                 float* out) {
  const int radius = window_pixels / 2;
  const int left = std::max(x - radius, 0);
  const int right = std::min(x + radius, image.width - 1);
  const int top = std::max(y - radius, 0);
  const int bottom = std::min(y + radius, image.height - 1);
  int64_t sums[3] = {0, 0, 0};
  for (int row = top; row <= bottom; ++row) {
    const uint8_t* pixels = image.data + row * image.stride_bytes;
    for (int column = left; column <= right; ++column) {
      for (int c = 0; c < image.channels; ++c) {
        sums[c] += pixels[column * image.channels + c];
      }
    }
  }
  const double scale = 2.0 / (255.0 * (right - left + 1) * (bottom - top + 1));
  const double m0 = sums[0] * scale - 1.0;
  const double m1 = image.channels == 1 ? m0 : sums[1] * scale - 1.0;
  const double m2 = image.channels == 1 ? m0 : sums[2] * scale - 1.0;
  out[0] = static_cast<float>(u);
  out[1] = static_cast<float>(v);
  out[2] = static_cast<float>(image.channels == 1 ? m0 : 0.299 * m2 + 0.587 * m1 + 0.114 * m0);
  out[3] = static_cast<float>(m2);
  out[4] = static_cast<float>(m1);
  out[5] = static_cast<float>(m0);
}

int NearestPixel(double coordinate, int size) {
  return std::clamp(static_cast<int>(std::floor(coordinate + 0.5)), 0, size - 1);
}

}  // namespace

void BoxMeansAt(const ImageView& image, ConstMatrixView<double> points, int window_pixels,
                MatrixView<float> out) {
  const PixelNormalization map = NormalizationForImage(image.width, image.height);
  for (int64_t i = 0; i < points.rows; ++i) {
    const double x = points(i, 0);
    const double y = points(i, 1);
    MeansAround(image, NearestPixel(x, image.width), NearestPixel(y, image.height), window_pixels,
                x * map.scale + map.u_offset, y * map.scale + map.v_offset, out.row(i));
  }
}

void BoxMeansOnGrid(const ImageView& image, const ImageGrid& grid, int window_pixels,
                    MatrixView<float> out) {
  const PixelNormalization map = NormalizationForImage(image.width, image.height);
  int64_t i = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const int x = grid.x_pixels(column);
      const int y = grid.y_pixels(row);
      MeansAround(image, x, y, window_pixels, x * map.scale + map.u_offset,
                  y * map.scale + map.v_offset, out.row(i++));
    }
  }
}

void GridInterpolation(const ImageGrid& grid, ConstMatrixView<float> values,
                       MatrixView<float> out) {
  for (int y = 0; y < grid.height; ++y) {
    const int r0 = y / grid.stride;
    const int r1 = std::min(r0 + 1, grid.rows() - 1);
    const int span_y = grid.y_pixels(r1) - grid.y_pixels(r0);
    const double fy = span_y > 0 ? static_cast<double>(y - grid.y_pixels(r0)) / span_y : 0.0;
    for (int x = 0; x < grid.width; ++x) {
      const int c0 = x / grid.stride;
      const int c1 = std::min(c0 + 1, grid.columns() - 1);
      const int span_x = grid.x_pixels(c1) - grid.x_pixels(c0);
      const double fx = span_x > 0 ? static_cast<double>(x - grid.x_pixels(c0)) / span_x : 0.0;
      const double top = (1.0 - fx) * values(r0, c0) + fx * values(r0, c1);
      const double bottom = (1.0 - fx) * values(r1, c0) + fx * values(r1, c1);
      out(y, x) = static_cast<float>((1.0 - fy) * top + fy * bottom);
    }
  }
}

}  // namespace egosieve::kernels::reference
