// Chooses the frame gap of a pair (frame_gap auto), so that there is enough parallax.
//
//   p <- p^(1-w) (parallax / gap)^w        pixels per picture, tracked over the drive        (GC1)
//   gap = ceil(wanted / p),  at most `longest`;  1 where p < least                           (GC2)
//
// With the calibrated motion (two_view_motion.h), parallax is the median over the static points of
// the image motion that rotation does not explain. A camera that hardly travels takes the longest
// gap: it shows slow motion, and fast motion is followed over one picture (pair_motions.h).
//
// With a selected model, parallax is the median residual of the best homography (motion_model.h).
// If that is close to zero, a longer gap gives no more parallax, only longer flow.
//
// The gap stays as it is while wanted / p moves by less than `margin` beyond it.
#pragma once

namespace egosieve::vision {

struct GapRule {
  double wanted_pixels = 0.0, least_pixels = 0.0;
};
inline constexpr GapRule kCalibratedGap = {3.0, 0.0}, kSelectedModelGap = {1.5, 0.35};

struct GapState {
  int gap = 1;
  bool has_parallax = false;
  double log_parallax = 0.0;  // log p
};

// parallax_pixels: of a pair whose frame gap is `gap`.
void ObserveParallax(double parallax_pixels, int gap, int longest, const GapRule& rule,
                     GapState& state);

}  // namespace egosieve::vision
