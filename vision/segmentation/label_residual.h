// Residual of the Gaussian process at a frame's own labels, applied near them.
//
// The process is smooth: a far car with ten of ten thousand labelled places gets a probability that
// peaks below 1/2. At labelled place i, let p_i be the label and q_i the process's probability. The
// residual is
//
//   r_i = logit(p_i) - logit(q_i),   both from 0.01 to 0.99                                 (LR1)
//
// and the log odds of each pixel of that frame are increased by
//
//   w m,   m = median of r over the 3 x 3 cells around it                                   (LR2)
//
// A cell is 5 pixels wide; its r is that of the nearest labelled place. A single label that differs
// from its neighbours changes nothing. With w = 0 the Gaussian process alone decides. This is a
// local part beside the global one, as in Snelson & Ghahramani, "Local and global sparse Gaussian
// process approximations" (2007). It holds for that frame alone and is not learnt.
//
// m is kept on the grid of cells in steps of 1/12, one byte each, independent of the map's grid.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"
#include "vision/image/image_grid.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

// Every grid pixel gets the value of its nearest feature. positions: N x 2, (x, y) in pixels;
// values: N. Returns grid.size() values, row-major; all are 0 if there are no features. Distances
// are Euclidean; of equally near features the first one counts. O(grid log N).
std::vector<float> SpreadToGrid(kernels::ConstMatrixView<double> positions,
                                const std::vector<double>& values, const ImageGrid& grid);

class LabelResidual {
 public:
  LabelResidual() = default;  // of no frame: changes no map

  // For frame `frame_index` of `size` pixels. positions: N x 2, pixels; labels, own: N, p and q of
  // (LR1), in [0, 1]. Without places it changes no map.
  LabelResidual(int64_t frame_index, cv::Size size, kernels::ConstMatrixView<double> positions,
                absl::Span<const double> labels, absl::Span<const float> own);

  // Applies (LR2) to the map's probability if the map is of the same frame and size.
  void Apply(double weight, SegmentationMap& map) const;

 private:
  int64_t frame_index_ = -1;
  ImageGrid grid_;
  std::vector<int8_t> steps_;  // grid_.size(); empty: no frame
};

}  // namespace egosieve::vision
