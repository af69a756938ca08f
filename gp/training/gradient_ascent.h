// Gradient ascent by iRprop-: each coordinate has its own step, which grows while the gradient
// keeps its sign and shrinks when the sign changes. Only signs are used, so that noise in the
// gradient's size (a new subset of the data per round) does little harm.
//
//   s_t := min(1.2 s_t, s_max)            if g_t g_t' > 0,  g' the previous gradient
//   s_t := max(0.5 s_t, s_min), g_t := 0  if g_t g_t' < 0
//   theta_t := clamp(theta_t + sign(g_t) s_t)
//
// s_t is 0.1 at first, s_min 1e-4 and s_max 0.5, in units of theta.
//
// Reference: Igel & Huesken (2000), "Improving the Rprop learning algorithm".
#pragma once

#include <vector>

#include "absl/types/span.h"
#include "gp/covariance/hyperparameters.h"

namespace egosieve::gp {

struct RpropState {
  std::vector<double> steps;              // empty before the first step
  std::vector<double> previous_gradient;  // likewise
};

// One step of theta along `gradient`. Sizes must be equal.
void RpropStep(absl::Span<const double> gradient, const HyperparameterBounds& bounds,
               RpropState& state, std::vector<double>& theta);

}  // namespace egosieve::gp
