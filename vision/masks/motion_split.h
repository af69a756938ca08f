// Decides whether the cells of a region have one motion or two.
//
//   d_i     displacement of cell i over the longest horizon over which most cells hold
//           (moving_cells.h)
//   one     motion (mover_motion.h, D2) fitted to all d_i
//   two     two motions and labels, each cell with the motion of the smaller cost over the 3 x 3
//           cells around it, iterated from five starts: the cells that do not fit the one motion,
//           and halves by position and by displacement; cost rho(r) = r^2 / (r^2 + scale^2)   (MS1)
//   parts   accepted where, on the smaller part, its own motion costs less than kLessCost of the cost
//           of the other motion, the two motions differ by more than kParting times the part's
//           size, the root of its area, and the part is mostly one connected piece; the larger
//           part may lie on both sides of it                                                  (MS2)
//
// Limbs swing by less than their size. Two vehicles, or a person in front of a vehicle, separate by
// more.
//
// References: Wang & Adelson (1994), layers of motion; Ochs, Malik & Brox (2014), motion over more
// than two frames.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/masks/moving_cells.h"

namespace egosieve::vision {

struct MotionSplit {
  std::vector<int> larger, smaller;  // indices of the cells that hold for one step at least
};

// of: indices of the region's cells. Nothing where they have one motion.
std::optional<MotionSplit> SplitByMotion(const MovingCells& cells, const std::vector<int>& of);

// The distance between the motion of the cells `part` and that of the cells `whole`: the median
// distance of the displacements of `part` from the motion of `whole`, over the longest horizon over
// which two fifths of both hold. It is divided by the allowed distance, 1.5 pixels plus `share` of
// the length of the motion of `whole`. Below 1 they move alike. Nothing without such a horizon.
std::optional<double> MotionDistance(const MovingCells& cells, const std::vector<int>& part,
                                     const std::vector<int>& whole, double share);

}  // namespace egosieve::vision
