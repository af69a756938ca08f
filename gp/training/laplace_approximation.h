// Gaussian process classification by Laplace's approximation (Rasmussen & Williams, 3.4): the
// posterior of f given labels t in {-1, 1}, with the probit likelihood, as a Gaussian.
//
//   log p(t | f) = sum_i w_i log Phi(t_i f_i)      w_i: a row of weight 2 counts as two rows
//   g = its gradient, W = -its second derivative (diagonal, positive), W' = dW / df
//   f^ = K g(f^), by Newton's method, from B = I + W^1/2 K W^1/2 = L L^T             (LA1)
//   log Z = -1/2 g.f^ + log p(t | f^) - 1/2 log |B|                                  (LA2)
//   2 dlog Z = tr( (g g^T - R + u g^T + g u^T) dK ),   R = W^1/2 B^-1 W^1/2
//     u = (I - R K) s,   s_i = -1/2 W'_i / W_i (1 - [B^-1]_ii)                       (LA3)
//
// (LA1) is algorithm 3.1, (LA2) eq. 3.32 and (LA3) algorithm 5.1 with all of theta in one pass over
// K. The approximate posterior is that of the regression of y = f^ + g / W with noise variances
// 1 / W_i: mean k*.g and variance k** - k*.(K + W^-1)^-1 k* (eqs. 3.21, 3.24). The predictive
// probability Phi(mean / sqrt(1 + variance)) is exact for this Gaussian (eq. 3.82).
//
// Cost: n^3 / 3 flops for each Newton step, of which 5 to 10 are needed, and 2 n^3 / 3 for the
// gradient. Memory: three n x n arrays of float64.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/training/marginal_likelihood.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct LabelledInputs {
  kernels::ConstMatrixView<double> inputs;  // n x D, finite
  absl::Span<const double> labels;          // n, -1 or 1
  absl::Span<const double> weights;         // n, positive; empty: all 1
};

struct LaplaceApproximation {
  double log_likelihood = 0.0;          // (LA2)
  std::vector<double> gradient;         // (LA3): log scales, log sigma_f; empty if not requested
  std::vector<double> targets;          // y of the equivalent regression
  std::vector<double> noise_variances;  // 1 / W of it, at least 1
};

// InvalidArgument, with the row, for labels and weights that are not as above.
absl::StatusOr<LaplaceApproximation> ApproximateByLaplace(
    kernels::Context& context, const kernels::CovarianceParameters& covariance,
    const LabelledInputs& data, LikelihoodOrder order);

}  // namespace egosieve::gp
