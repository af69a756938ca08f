#include "gp/training/gradient_ascent.h"

#include <algorithm>

namespace egosieve::gp {

void RpropStep(absl::Span<const double> gradient, const HyperparameterBounds& bounds,
               RpropState& state, std::vector<double>& theta) {
  constexpr double kInitialStep = 0.1, kMinimumStep = 1e-4, kMaximumStep = 0.5;
  if (state.steps.size() != theta.size()) {
    state.steps.assign(theta.size(), kInitialStep);
    state.previous_gradient.assign(theta.size(), 0.0);
  }
  for (size_t i = 0; i < theta.size(); ++i) {
    double slope = gradient[i];
    const double agreement = slope * state.previous_gradient[i];
    if (agreement > 0.0) {
      state.steps[i] = std::min(1.2 * state.steps[i], kMaximumStep);
    } else if (agreement < 0.0) {
      state.steps[i] = std::max(0.5 * state.steps[i], kMinimumStep);
      slope = 0.0;
    }
    if (slope > 0.0) theta[i] += state.steps[i];
    if (slope < 0.0) theta[i] -= state.steps[i];
    state.previous_gradient[i] = slope;
  }
  bounds.Clamp(theta);
}

}  // namespace egosieve::gp
