// Linear reconstruction of a map from its grid (vision/image/image_grid.h) at every pixel: bilinear
// in each grid cell, exact at grid pixels; the last column and row of cells may be narrower.
//
// After an error `out` is unchanged.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/matrix_view.h"
#include "vision/image/image_grid.h"

namespace egosieve::vision {

// values: grid.rows() x grid.columns(); out: grid.height x grid.width.
absl::Status GridInterpolation(const ImageGrid& grid, kernels::ConstMatrixView<float> values,
                               kernels::MatrixView<float> out);

}  // namespace egosieve::vision
