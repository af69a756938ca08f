// Simulated annealing within a box. It finds the neighbourhood of a good maximum, not the maximum.
//
//   theta' = clamp(theta + s_k z),  z ~ N(0, diag((upper - lower)^2))
//   accept if J(theta') >= J(theta) or with probability exp((J(theta') - J(theta)) / T_k)
//
// T_k falls geometrically from 0.1 to 0.002; s_k is proportional to its square root and begins with
// 0.3. Each move changes a random half of the coordinates (at least
// one). Reference: Kirkpatrick, Gelatt & Vecchi (1983), "Optimization by simulated annealing".
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"

namespace egosieve::gp {

struct AnnealingResult {
  std::vector<double> theta;  // the best one found
  double objective = -std::numeric_limits<double>::infinity();
};

// Maximises `objective` by so many evaluations from `start`, which is clamped to the bounds and
// evaluated first. Points with an objective of NaN or -infinity are never accepted; errors of the
// objective end the search.
absl::StatusOr<AnnealingResult> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds, int64_t evaluations,
    uint64_t seed);

}  // namespace egosieve::gp
