#include "kernels/ops/grid_interpolation.h"

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_image.h"
#include "kernels/reference/image.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {

absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out) {
  EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("values", values, grid.rows(), grid.columns()));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("values", values));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, grid.height, grid.width));
  if (context.is_reference()) {
    reference::GridInterpolation(grid, values, out);
    return absl::OkStatus();
  }
  return opencl::GridInterpolation(context, grid, values, out);
}

}  // namespace egosieve::kernels
