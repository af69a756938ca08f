// Box means and grid interpolation on an OpenCL device. Arguments must be valid.
//
// On devices with one work-item per core, a work-item keeps sliding sums along a band of rows, and
// interpolates row by row. On devices that run work-items side by side, each takes a point or a
// pixel, in groups of 64. The bits are the same.
//
// On an H200 (4.8 TB/s, 132 units of 2,048 work-items), counted, not measured, for every pixel of
// 1242 x 375 and windows of 7 pixels: 465,750 work-items in 7,500 groups fill the 132 x 32 slots
// for groups 1.8 times, with 2,048 work-items per unit; no local memory.
//
//   kernel                       reads            writes            of device memory
//   box_means_on_grid_by_point   147 bytes each   24 bytes each     1.4 + 11.2 MB, 0.003 ms
//   grid_interpolation_by_pixel  16 bytes each    4 bytes each      1.9 + 1.9 MB, 0.001 ms
//
// The 147 bytes of a window overlap with those of neighbouring windows: 68 MB come from the cache.
// The bus, at 55 GB/s, takes longer: 0.23 and 0.07 ms.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

absl::Status BoxMeansOnGrid(Context& context, const ImageView& image, const ImageGrid& grid,
                            int window_pixels, MatrixView<float> out);

absl::Status BoxMeansAt(Context& context, const ImageView& image, ConstMatrixView<double> points,
                        int window_pixels, MatrixView<float> out);

absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out);

}  // namespace egosieve::kernels::opencl
