// The inputs of the segmentation's Gaussian process, computed from an image:
//
//   x = (u, v, I_M, I_R, I_G, I_B)                                          (paper, section III)
//
// u, v as in kernels/base/image_grid.h; I_. are means over a square window of `window_pixels`
// around the pixel, clipped at the image border (the mean is over existing pixels), mapped from [0,
// 255] to [-1, 1]. M = 0.299 R + 0.587 G + 0.114 B. A grey image has I_R = I_G = I_B = I_M. A point
// between pixels has the window of the nearest pixel and its own u, v.
//
// After an error in the arguments, or a device error before the computation began, `out` is
// unchanged; after a device is lost during the computation `out` may be partly written.
#ifndef EGOSIEVE_KERNELS_OPS_DESCRIPTOR_FIELD_H_
#define EGOSIEVE_KERNELS_OPS_DESCRIPTOR_FIELD_H_

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

inline constexpr int kDescriptorDimension = 6;

struct DescriptorOptions {
  int window_pixels = 7;  // side of the square window; odd
  absl::Status Validate() const;
};

// out: grid.size() x 6, row-major over the grid's rows and columns.
absl::Status DescriptorField(Context& context, const ImageView& image, const ImageGrid& grid,
                             const DescriptorOptions& options, MatrixView<float> out);

// points: N x 2, (x, y) in pixels, inside the image; out: N x 6. At a grid's pixels the results
// equal DescriptorField's bit for bit.
absl::Status DescriptorsAt(Context& context, const ImageView& image, ConstMatrixView<double> points,
                           const DescriptorOptions& options, MatrixView<float> out);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_OPS_DESCRIPTOR_FIELD_H_
