// The six inputs of the segmentation's Gaussian process (paper, section III):
//
//   x = (u, v, I_M, I_R, I_G, I_B)
//
// I_. are means over a window, by vision/image/box_means.h on the channels B, G, R; M = 0.299 R +
// 0.587 G + 0.114 B. A grey frame has I_R = I_G = I_B = I_M. They are computed at given positions
// of a frame, for learning, and on a grid over the whole frame, for inference. Both use the same
// code, so they give the same bytes at the pixels of a grid.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"
#include "vision/frame/frame.h"
#include "vision/image/box_means.h"
#include "vision/image/image_grid.h"

namespace egosieve::vision {

inline constexpr int kDescriptorDimension = kBoxMeanColumns;
using DescriptorOptions = BoxMeanOptions;

// positions: N x 2, (x, y) in pixels of the frame. Returns N x 6, row-major.
absl::StatusOr<std::vector<float>> DescribePositions(const Frame& frame,
                                                     kernels::ConstMatrixView<double> positions,
                                                     const DescriptorOptions& options = {});

// Returns grid.size() x 6, row-major. The grid must have the frame's size.
absl::StatusOr<std::vector<float>> DescribeGrid(const Frame& frame, const ImageGrid& grid,
                                                const DescriptorOptions& options = {});

}  // namespace egosieve::vision
