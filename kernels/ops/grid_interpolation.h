// Linear reconstruction of a map from its grid (kernels/base/image_grid.h) to every pixel: bilinear
// in each grid cell, exact at grid pixels; the last column and row of cells may be narrower.
//
// After an error in the arguments, or one of the device before it began to compute, `out` is as it
// was; of a device that is lost in the middle `out` may hold parts.
#ifndef EGOSIEVE_KERNELS_OPS_GRID_INTERPOLATION_H_
#define EGOSIEVE_KERNELS_OPS_GRID_INTERPOLATION_H_

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// values: grid.rows() x grid.columns(); out: grid.height x grid.width.
absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_OPS_GRID_INTERPOLATION_H_
