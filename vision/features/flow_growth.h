// Corrects dense flow where it follows the wrong surface.
//
// Coarse-to-fine flow loses small fast objects in the motion of their background: points on a
// crossing car get the background's displacement, or one that does not lead back. Here the textured
// points of a grid are checked by the pictures themselves, and correct displacements grow into
// points that fail (match propagation: Lhuillier & Quan, PAMI 2002):
//
//   c(d)      correlation of a patch with the other picture's, displaced by d (flow_patch.h)
//   holds     a point whose flow leads back and has c >= kHolds; settled: also c >= kSettled
//   seeds     points that do not hold, a fourth of the grid, each searched for by itself
//             (patch_search.h)
//   growth    a point that is not settled takes over the displacement of a neighbour, aligned,
//             where that leads back, c >= kAccepted, and 1 - c at least halves if
//             the point held before
//
// until nothing changes, or for kMostSweeps sweeps. A correct match spreads over the object on
// which it lies and stops at the object's edge, where patches of the object no longer agree.
#pragma once

#include <opencv2/core.hpp>

#include "vision/features/flow_grid.h"

namespace egosieve::vision {

// Corrects both fields around the points that are found, in squares of `options.stride_pixels`.
// Other pixels keep their flow. The pictures must be those from which the flow was computed.
// Returns the number of corrected points.
int64_t GrowFlow(const cv::Mat& first, const cv::Mat& second, const FlowGridOptions& options,
                 FlowPair& flow);

}  // namespace egosieve::vision
