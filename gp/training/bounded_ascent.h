// Maximises a smooth function f over a box by projected limited-memory BFGS.
//
//   p = clamp(theta + g) - theta,  g the gradient of f             the projected gradient     (PL1)
//   free: the coordinates that are not on a bound which g points out of
//   d = H g over the free coordinates, H from the last 10 pairs of steps and changes of
//       the gradient (two-loop recursion), scaled by s.y / y.y of the newest                  (PL2)
//   theta(t) = clamp(theta + t d) with f(theta(t)) >= f(theta) + 1e-4 g.(theta(t) - theta)    (PL3)
//
// t begins at 1. It is halved until (PL3) holds, and doubled while f still rises steeply along the
// step. Pairs of negative curvature are left out, so H stays positive definite. f may be -infinity
// where it has no value: such a step is halved.
//
// References: Nocedal & Wright (2006), algorithms 7.4 and 3.1; Bertsekas (1982), projected Newton
// methods.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"

namespace egosieve::gp {

// f at theta, and its gradient, of the same size.
using ValueAndGradient = std::function<absl::StatusOr<double>(const std::vector<double>& theta,
                                                              std::vector<double>& gradient)>;

struct AscentOptions {
  int steps = 500;          // accepted steps at most
  double tolerance = 1e-3;  // of the largest |p|
};

struct AscentResult {
  std::vector<double> theta;
  double value = -std::numeric_limits<double>::infinity();
  double gradient_norm = 0.0;  // the largest |p|
  bool converged = false;      // gradient_norm <= tolerance
};

// Begins at `theta`, clamped to the bounds. The value never falls; it is -infinity if f has none at
// the start. An error of f is returned.
absl::StatusOr<AscentResult> Ascend(const ValueAndGradient& f, std::vector<double> theta,
                                    const HyperparameterBounds& bounds,
                                    const AscentOptions& options = {});

}  // namespace egosieve::gp
