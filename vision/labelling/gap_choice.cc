#include "vision/labelling/gap_choice.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {
namespace {

constexpr double kWantedPixels = 3.0;
constexpr double kWeight = 0.3;  // w
constexpr double kMargin = 0.25;
constexpr double kFloorPixels = 0.01;

}  // namespace

void ObserveParallax(double parallax_pixels, int gap, int longest, GapState& state) {
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
