// Linear reconstruction of a map from its grid (kernels/base/image_grid.h) at every pixel: bilinear
// in each grid cell, exact at grid pixels; the last column and row of cells may be narrower.
//
// After an error in the arguments, or a device error before the computation began, `out` is
// unchanged; after a device is lost during the computation `out` may be partly written.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// values: grid.rows() x grid.columns(); out: grid.height x grid.width.
absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out);

}  // namespace egosieve::kernels
