// Simulated annealing within a box. It finds the neighbourhood of a good maximum, not the maximum.
//
//   theta' = clamp(theta + s_k z),  z ~ N(0, diag((upper - lower)^2))
//   accept if J(theta') >= J(theta) or with probability exp((J(theta') - J(theta)) / T_k)
//
// T_k falls geometrically from the first temperature to the last; s_k is proportional to its square
// root and begins with `initial_step`. Each move changes a random half of the coordinates (at least
// one). Reference: Kirkpatrick, Gelatt & Vecchi (1983), "Optimization by simulated annealing".
#pragma once

#include <cstdint>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"

namespace egosieve::gp {

struct AnnealingOptions {
  int64_t evaluations = 150;       // of J
  double first_temperature = 0.1;  // in units of J
  double last_temperature = 0.002;
  double initial_step = 0.3;  // of the box's sides
  uint64_t seed = 1;

  absl::Status Validate() const;
};

struct AnnealingResult {
  std::vector<double> theta;  // the best one found
  double objective = 0.0;
  int64_t evaluations = 0;
  int64_t accepted = 0;
};

// Maximises `objective` from `start`, which is clamped to the bounds and evaluated first. Points
// with an objective of NaN or -infinity are never accepted; errors of the objective end the search.
absl::StatusOr<AnnealingResult> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds,
    const AnnealingOptions& options = {});

}  // namespace egosieve::gp
