#include "gp/training/gradient_ascent.h"

#include <algorithm>

namespace egosieve::gp {

void RpropStep(absl::Span<const double> gradient, const HyperparameterBounds& bounds,
               const RpropOptions& options, RpropState& state, std::vector<double>& theta) {
  if (state.steps.size() != theta.size()) {
    state.steps.assign(theta.size(), options.initial_step);
    state.previous_gradient.assign(theta.size(), 0.0);
  }
  for (size_t i = 0; i < theta.size(); ++i) {
    double slope = gradient[i];
    const double agreement = slope * state.previous_gradient[i];
    if (agreement > 0.0) {
      state.steps[i] = std::min(1.2 * state.steps[i], options.maximum_step);
    } else if (agreement < 0.0) {
      state.steps[i] = std::max(0.5 * state.steps[i], options.minimum_step);
      slope = 0.0;
    }
    if (slope > 0.0) theta[i] += state.steps[i];
    if (slope < 0.0) theta[i] -= state.steps[i];
    state.previous_gradient[i] = slope;
  }
  bounds.Clamp(theta);
}

}  // namespace egosieve::gp
