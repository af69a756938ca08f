// The pixels of an image at which the posterior is evaluated, and the map from pixel coordinates to
// inputs.
//
// A grid consists of every s-th column 0, s, 2 s, ... and always the last one; likewise for rows.
// Its first and last columns and rows lie on the image border, so interpolation never extrapolates.
// s = 1 is every pixel.
//
//   columns = ceil((width - 1) / s) + 1,     x_c = min(c s, width - 1)
//
// Pixel coordinates (x, y), with pixel centres at integers, map to inputs so that the longer side
// spans [-1, 1] and the aspect ratio is kept:
//
//   u = (2 x - (width - 1)) / (max(width, height) - 1),   v = (2 y - (height - 1)) / (...)
#pragma once

#include <algorithm>
#include <cstdint>

#include "absl/status/status.h"

namespace egosieve::vision {

struct ImageGrid {
  int width = 0;   // of the image, pixels
  int height = 0;  // of the image, pixels
  int stride = 5;  // pixels between neighbouring grid columns and rows

  int columns() const { return width < 1 ? 0 : (width - 1 + stride - 1) / stride + 1; }
  int rows() const { return height < 1 ? 0 : (height - 1 + stride - 1) / stride + 1; }
  int64_t size() const { return static_cast<int64_t>(columns()) * rows(); }
  int x_pixels(int column) const { return std::min(column * stride, width - 1); }
  int y_pixels(int row) const { return std::min(row * stride, height - 1); }

  // InvalidArgument, naming field and value, unless width, height and stride are all positive.
  absl::Status Validate() const;
};

// The affine map from pixels to inputs: u = x * scale + u_offset, v = y * scale + v_offset.
struct PixelNormalization {
  double scale = 1.0;
  double u_offset = 0.0;
  double v_offset = 0.0;
};

// A 1 x 1 image maps to (0, 0).
PixelNormalization NormalizationForImage(int width, int height);

}  // namespace egosieve::vision
