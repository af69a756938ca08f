// The shadows that movers cast on the ground beside their feet.
//
//   near      pixels of no mover, nearer than the margin to this one, not above the lower quarter
//             of its box
//   dark      brightness, smoothed by 2 pixels, below 0.6 of the ground's: the 70th percentile of
//             what is near                                                              (SH1)
//   shadow    connected parts of what is near and dark that reach the mover within 4 pixels (CS2)
//
// A shadow is distinguished from the ground by its darkness alone: what else is dark and begins at
// the feet, a hole, a hedge, a flower pot, is taken for one; what lies in shadow already has none.
#ifndef EGOSIEVE_TOOLS_MASKS_CAST_SHADOWS_H_
#define EGOSIEVE_TOOLS_MASKS_CAST_SHADOWS_H_

#include <opencv2/core.hpp>

namespace egosieve::tools {

// 255 where a mover of `moving` (0 or not, connected parts of 50 pixels or more) casts a shadow in
// `picture`, which has the same size.
cv::Mat1b FindCastShadows(const cv::Mat3b& picture, const cv::Mat1b& moving, int margin_pixels);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_CAST_SHADOWS_H_
