// The log marginal likelihood of a Gaussian process and its gradient with respect to theta
// (Rasmussen & Williams, eqs. 5.8 and 5.9).
//
//   log p(y | X) = -1/2 y.alpha - sum_i log L_ii - n/2 log 2 pi,   L L^T = K_y           (1)
//   d/d theta_t  = 1/2 tr( (alpha alpha^T - K_y^-1) dK_y/d theta_t ),   alpha = K_y^-1 y (2)
//   K_y = K + diag(sigma_n^2 + v_i);  dK_y/d log sigma_n = 2 sigma_n^2 I                 (3)
//
// With a mean function (1) is the restricted likelihood (W5) of gp/model/regression_weights.h, and
// P replaces K_y^-1 in (2): d (log|K_y| + log|A|) = tr(P dK_y). For k outputs the values and
// gradients are added.
//
// Cost: n^3 / 3 flops for the value, n^3 with the gradient, plus one pass over the pairs for all of
// theta. Memory: two n x n arrays of float64, in the device's memory if it has its own, with float64,
// and the mean is zero (kernels/ops/exact_regression.h).
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct MarginalLikelihood {
  double value = 0.0;            // (1)
  std::vector<double> gradient;  // (2), in the order of ToLogarithms; empty if not requested
};

enum class LikelihoodOrder { kValue, kValueAndGradient };

// n = 0: value 0 and a gradient of zeros. FailedPrecondition if K_y is not positive definite to
// working precision, or if the points do not determine the mean function.
absl::StatusOr<MarginalLikelihood> ComputeMarginalLikelihood(kernels::Context& context,
                                                             const Hyperparameters& hyperparameters,
                                                             const Observations& data,
                                                             LikelihoodOrder order);

}  // namespace egosieve::gp
