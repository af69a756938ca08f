#include "tools/evaluation/map_sample.h"

#include <algorithm>

#include "vision/image/bilinear.h"

namespace egosieve::tools {
namespace {

// The grid pixels around a position. The last step of a grid may be shorter than the others.
vision::Around<double> AmongGridPixels(double position, int stride, int count, int last_pixel) {
  if (count < 2) return {0, 0, 0.0};
  const int before = std::clamp(static_cast<int>(position / stride), 0, count - 2);
  const int low = before * stride, high = std::min(low + stride, last_pixel);
  return {before, before + 1, std::clamp((position - low) / (high - low), 0.0, 1.0)};
}

}  // namespace

double InterpolateAt(const cv::Mat1f& map, const kernels::ImageGrid& grid, double x, double y) {
  return vision::BilinearByDifferences(
      AmongGridPixels(x, grid.stride, grid.columns(), grid.width - 1),
      AmongGridPixels(y, grid.stride, grid.rows(), grid.height - 1),
      [&](int row, int column) { return static_cast<double>(map(row, column)); });
}

}  // namespace egosieve::tools
