// The steps of gp/training/hyperparameter_trainer.h within a box.
//
// Simulated annealing finds the neighbourhood of a good maximum, not the maximum:
//
//   theta' = clamp(theta + s_k z),  z ~ N(0, diag((upper - lower)^2))
//   accept if J(theta') >= J(theta) or with probability exp((J(theta') - J(theta)) / T_k)
//
// T_k falls geometrically from 0.1 to 0.002; s_k is proportional to its square root and begins with
// 0.3. Each move changes a random half of the coordinates (at least one).
//
// Gradient ascent by iRprop-: each coordinate has its own step, which grows while the gradient keeps
// its sign and shrinks when the sign changes. Only signs are used, so that noise in the gradient's size
// (a new subset of the data per round) does little harm.
//
//   s_t := min(1.2 s_t, s_max)            if g_t g_t' > 0,  g' the previous gradient
//   s_t := max(0.5 s_t, s_min), g_t := 0  if g_t g_t' < 0
//   theta_t := clamp(theta_t + sign(g_t) s_t)
//
// s_t is 0.1 at first, s_min 1e-4 and s_max 0.5, in units of theta.
//
// References: Kirkpatrick, Gelatt & Vecchi (1983), "Optimization by simulated annealing"; Igel &
// Huesken (2000), "Improving the Rprop learning algorithm".
#pragma once

#include <cstdint>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/covariance/hyperparameters.h"

namespace egosieve::gp {

// Maximises `objective` by so many evaluations from `start`, which is clamped to the bounds and
// evaluated first; gives the best theta found. Points with an objective of NaN or -infinity are never
// accepted; errors of the objective end the search.
absl::StatusOr<std::vector<double>> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds, int64_t evaluations,
    uint64_t seed);

struct RpropState {
  std::vector<double> steps;              // empty before the first step
  std::vector<double> previous_gradient;  // likewise
};

// One step of theta along `gradient`. Sizes must be equal.
void RpropStep(absl::Span<const double> gradient, const HyperparameterBounds& bounds,
               RpropState& state, std::vector<double>& theta);

}  // namespace egosieve::gp
