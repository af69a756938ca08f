// Descriptors and grid interpolation on an OpenCL device. Arguments are taken as valid.
#ifndef EGOSIEVE_KERNELS_OPS_OPENCL_IMAGE_H_
#define EGOSIEVE_KERNELS_OPS_OPENCL_IMAGE_H_

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

absl::Status DescriptorField(Context& context, const ImageView& image, const ImageGrid& grid,
                             int window_pixels, MatrixView<float> out);

absl::Status DescriptorsAt(Context& context, const ImageView& image, ConstMatrixView<double> points,
                           int window_pixels, MatrixView<float> out);

absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out);

}  // namespace egosieve::kernels::opencl

#endif  // EGOSIEVE_KERNELS_OPS_OPENCL_IMAGE_H_
