// Chooses the frame gap of a pair (frame_gap auto), so that there is enough parallax.
//
//   p <- p^(1-w) (parallax / gap)^w        pixels per picture, tracked over the drive        (GC1)
//   gap = ceil(wanted / p),  at most `longest`;  wanted = 3 pixels                           (GC2)
//
// Parallax is the median over the static points of the image motion that rotation does not explain
// (two_view_motion.h). A camera that hardly travels takes the longest gap: it shows slow motion, and
// fast motion is followed over one picture (pair_motions.h).
//
// The gap stays as it is while wanted / p moves by less than `margin` beyond it.
#pragma once

#include <algorithm>
#include <cmath>

namespace egosieve::vision {

struct GapState {
  int gap = 1;
  bool has_parallax = false;
  double log_parallax = 0.0;  // log p
};

// parallax_pixels: of a pair whose frame gap is `gap`.
inline void ObserveParallax(double parallax_pixels, int gap, int longest, GapState& state) {
  constexpr double kWantedPixels = 3.0, kFloorPixels = 0.01;
  constexpr double kWeight = 0.3;  // w
  constexpr double kMargin = 0.25;
  if (!(parallax_pixels >= 0.0) || std::isinf(parallax_pixels) || gap < 1) return;
  const double observed = std::log(std::max(parallax_pixels / gap, kFloorPixels));
  state.log_parallax =
      state.has_parallax ? (1.0 - kWeight) * state.log_parallax + kWeight * observed : observed;
  state.has_parallax = true;
  const double wanted = kWantedPixels / std::exp(state.log_parallax);
  if (wanted > state.gap - 1 - kMargin && wanted <= state.gap + kMargin) return;
  state.gap = std::clamp(static_cast<int>(std::ceil(wanted)), 1, longest);
}

}  // namespace egosieve::vision
