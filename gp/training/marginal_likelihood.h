// The log marginal likelihood of a Gaussian process and its gradient by theta (Rasmussen &
// Williams, eqs. 5.8 and 5.9).
//
//   log p(y | X) = -1/2 y.alpha - sum_i log L_ii - n/2 log 2 pi,   L L^T = K_y           (1)
//   d/d theta_t  = 1/2 tr( (alpha alpha^T - K_y^-1) dK_y/d theta_t ),   alpha = K_y^-1 y (2)
//   K_y = K + sigma_n^2 I;  dK_y/d log sigma_n = 2 sigma_n^2 I                           (3)
//
// Cost: n^3 / 3 flops for the value, n^3 with the gradient, plus one pass over the pairs for all of
// theta. Memory: two n x n arrays of float64.
#ifndef EGOSIEVE_GP_TRAINING_MARGINAL_LIKELIHOOD_H_
#define EGOSIEVE_GP_TRAINING_MARGINAL_LIKELIHOOD_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/covariance/hyperparameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct MarginalLikelihood {
  double value = 0.0;            // (1)
  std::vector<double> gradient;  // (2), in the order of ToLogarithms; empty where not asked for
};

enum class LikelihoodOrder { kValue, kValueAndGradient };

// x: n x D; targets: n. n = 0: value 0 and a gradient of zeros. FailedPrecondition where K_y is not
// positive definite to working precision.
absl::StatusOr<MarginalLikelihood> ComputeMarginalLikelihood(kernels::Context& context,
                                                             const Hyperparameters& hyperparameters,
                                                             kernels::ConstMatrixView<double> x,
                                                             absl::Span<const double> targets,
                                                             LikelihoodOrder order);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_TRAINING_MARGINAL_LIKELIHOOD_H_
