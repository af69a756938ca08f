// Probabilities from a classifier's decision values (Platt, 1999): a sigmoid fitted by maximum
// likelihood.
//
//   p(f) = 1 / (1 + exp(A f + B))                                                    (PS1)
//   minimise -sum_i t_i log p_i + (1 - t_i) log(1 - p_i),
//   t_i = (N+ + 1) / (N+ + 2) for positives, 1 / (N- + 2) for negatives              (PS2)
//
// It uses Newton's method with backtracking on a convex function, in the form without overflow or
// cancellation (Lin, Lin and Weng, A note on Platt's probabilistic outputs for support vector
// machines, 2007). The decision values must not be those of the classifier's training points.
#ifndef EGOSIEVE_VISION_BASELINES_PLATT_SIGMOID_H_
#define EGOSIEVE_VISION_BASELINES_PLATT_SIGMOID_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

struct PlattSigmoid {
  double a = -1.0;  // A; negative if larger values favour the positive class
  double b = 0.0;

  double Probability(double decision) const;  // (PS1)
};

// One class alone, or no points, can be fitted as well: the targets of (PS2) bound the result.
// InvalidArgument if sizes differ or a value is not finite.
absl::StatusOr<PlattSigmoid> FitPlattSigmoid(const std::vector<double>& decisions,
                                             const std::vector<uint8_t>& positive);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_BASELINES_PLATT_SIGMOID_H_
