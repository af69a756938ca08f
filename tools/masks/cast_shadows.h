// Shadows that movers cast on the ground beside their feet.
//
//   near      pixels outside all movers, nearer than the margin to this one, not above the lower
//             quarter of its box
//   dark      brightness, smoothed by 2 pixels, below 0.6 of the ground's: the 70th percentile of
//             the near pixels                                                           (SH1)
//   shadow    connected parts of near, dark pixels that come within 4 pixels of the mover   (SH2)
//
// A shadow is distinguished from the ground only by its darkness. Other dark things that begin at
// the feet (a hole, a hedge, a flower pot) are taken for shadows. A mover that is itself in shadow
// has none.
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::tools {

// 255 where a mover of `moving` (0 or not, connected parts of 50 pixels or more) casts a shadow in
// `picture`, which has the same size.
cv::Mat1b FindCastShadows(const cv::Mat3b& picture, const cv::Mat1b& moving, int margin_pixels);

}  // namespace egosieve::tools
