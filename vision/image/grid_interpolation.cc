#include "vision/image/grid_interpolation.h"

#include <algorithm>

#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

// Exact for f = 0 and f = 1.
float Between(float first, float second, float f) { return (1.0f - f) * first + f * second; }

}  // namespace

absl::Status GridInterpolation(const ImageGrid& grid, kernels::ConstMatrixView<float> values,
                               kernels::MatrixView<float> out) {
  EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckShape("values", values, grid.rows(), grid.columns()));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckFinite("values", values));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckShape("out", out, grid.height, grid.width));
  kernels::ParallelFor(grid.height, 5.0 * grid.height * grid.width, [&](int64_t y) {
    const int row = static_cast<int>(y) / grid.stride, next = std::min(row + 1, grid.rows() - 1);
    const int y0 = grid.y_pixels(row), height = grid.y_pixels(next) - y0;
    const float f = height > 0 ? static_cast<float>(y - y0) / static_cast<float>(height) : 0.0f;
    float* target = out.row(y);
    float left = Between(values(row, 0), values(next, 0), f);
    target[0] = left;
    for (int column = 1; column < grid.columns(); ++column) {
      const float right = Between(values(row, column), values(next, column), f);
      const int x0 = grid.x_pixels(column - 1), width = grid.x_pixels(column) - x0;
      for (int x = 1; x <= width; ++x) {
        target[x0 + x] = Between(left, right, static_cast<float>(x) / static_cast<float>(width));
      }
      left = right;
    }
  });
  return absl::OkStatus();
}

}  // namespace egosieve::vision
