// Dense flow corrected where it follows the wrong surface.
//
// Flow estimated from coarse to fine loses what is small and fast in the motion of what is behind
// it: places on a crossing car get the background's displacement, or one that does not lead back.
// Here the textured places of a grid are checked by the pictures themselves, and those that fail
// grow from those that hold (match propagation: Lhuillier & Quan, PAMI 2002):
//
//   c(d) = normalised correlation of a patch with the other picture's, displaced by d (FG1) a place
//   holds where its flow leads back and c >= kHolds; it is settled where c >= kSettled seeds:
//   places that do not hold, each searched for by itself (patch_search.h) growth: a place that is
//   not settled takes over the displacement of a neighbour, refined (Lucas-Kanade), where that
//   leads back, c >= kAccepted, and 1 - c at least halves
//
// until nothing changes. A correct match spreads over the object that it lies on and stops at its
// edge, where patches of the object no longer agree.
#ifndef EGOSIEVE_VISION_FEATURES_FLOW_GROWTH_H_
#define EGOSIEVE_VISION_FEATURES_FLOW_GROWTH_H_

#include <opencv2/core.hpp>

#include "vision/features/flow_grid.h"

namespace egosieve::vision {

// Corrects both fields around the places that are found, in squares of `options.stride_pixels`; the
// other pixels keep their flow. The pictures are those that the flow was computed from. Returns how
// many places were corrected.
int64_t GrowFlow(const cv::Mat& first, const cv::Mat& second, const FlowGridOptions& options,
                 FlowPair& flow);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_FLOW_GROWTH_H_
