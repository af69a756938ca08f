// The answer for one frame: probability and uncertainty on a grid over its pixels.
#ifndef EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_MAP_H_
#define EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_MAP_H_

#include <cstdint>
#include <vector>

#include "kernels/base/image_grid.h"

namespace egosieve::vision {

// All of grid.size(), row-major over the grid's rows and columns.
struct SegmentationMap {
  int64_t frame_index = 0;
  kernels::ImageGrid grid;
  std::vector<float> probability;  // of belonging to something that moves
  std::vector<float> mean;         // of f, whose labels are -1 (static) and 1 (dynamic)
  std::vector<float> deviation;    // standard deviation of f
  std::vector<float> potential;    // of potential_model.h; empty where it is not asked for
  int64_t clamped_variances = 0;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_MAP_H_
