// The six inputs x = (u, v, I_M, I_R, I_G, I_B) of kernels/ops/descriptor_field.h for frames: at
// given positions of a frame, for learning, and on a grid over the whole frame, for inference. Both
// use the same code, so they give the same bytes at the pixels of a grid.
#ifndef EGOSIEVE_VISION_DESCRIPTOR_FRAME_DESCRIPTOR_H_
#define EGOSIEVE_VISION_DESCRIPTOR_FRAME_DESCRIPTOR_H_

#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/descriptor_field.h"
#include "kernels/runtime/context.h"
#include "vision/frame/frame.h"

namespace egosieve::vision {

// positions: N x 2, (x, y) in pixels of the frame. Returns N x 6, row-major.
absl::StatusOr<std::vector<float>> DescribePositions(
    kernels::Context& context, const Frame& frame, kernels::ConstMatrixView<double> positions,
    const kernels::DescriptorOptions& options = {});

// Returns grid.size() x 6, row-major. The grid must have the frame's size.
absl::StatusOr<std::vector<float>> DescribeGrid(kernels::Context& context, const Frame& frame,
                                                const kernels::ImageGrid& grid,
                                                const kernels::DescriptorOptions& options = {});

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_DESCRIPTOR_FRAME_DESCRIPTOR_H_
