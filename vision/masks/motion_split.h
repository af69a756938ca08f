// Whether the cells of a region move as one or as two.
//
//   d_i     displacement of cell i over the longest horizon over which most cells hold
//           (moving_cells.h)
//   one     motion (mover_motion.h, D2) fitted to all d_i
//   two     two motions and labels, each cell with the motion of the smaller cost over the 3 x 3
//           cells around it, iterated from five starts: what does not fit the one motion, and the
//           halves by place and by displacement; cost rho(r) = r^2 / (r^2 + scale^2)           (S1)
//   parts   where the smaller part's own motion has less than `gain` of the cost that the other's
//           has there, the motions part it from the other by more than `parting` times its size,
//           the root of its area, and it is mostly one piece; the larger may lie on both sides (S2)
//
// Limbs swing by less than their size; two vehicles, or a person before a vehicle, part by more.
//
// References: Wang & Adelson (1994), layers of motion; Ochs, Malik & Brox (2014), motion over more
// than two frames.
#ifndef EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_
#define EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/masks/moving_cells.h"

namespace egosieve::vision {

struct MotionSplitOptions {
  int min_cells = 6;        // of each part
  double least_held = 0.6;  // share of the cells, for a horizon
  double gain = 0.6;        // in (0, 1)
  double parting = 1.0;     // positive
};

struct MotionSplit {
  std::vector<int> larger, smaller;  // indices of the cells that hold for one step at least
};

// of: indices of the region's cells. Nothing where it moves as one.
std::optional<MotionSplit> SplitByMotion(const MovingCells& cells, const std::vector<int>& of,
                                         const MotionSplitOptions& options = {});

// Whether the cells `part` move as the cells `whole` do: the median distance from the motion of the
// whole, over the longest horizon over which two fifths of both hold, over what is allowed, 1.5
// pixels and `share` of the whole's motion. Below 1 they do; nothing without such a horizon.
std::optional<double> MotionDistance(const MovingCells& cells, const std::vector<int>& part,
                                     const std::vector<int>& whole, double share);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_
