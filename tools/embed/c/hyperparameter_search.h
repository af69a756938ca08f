// Maximises the log marginal likelihood from given hyperparameters until convergence, for programs
// that fit one model. In contrast, gp/training/hyperparameter_trainer.h follows a stream of data.
//
//   J(theta) = log p(y_S | X_S, theta),   theta = logarithms of scales, sigma_f, sigma_n
//
//   instead of log p, for a sparse model the objective of gp/training/sparse_likelihood.h: VFE for
//   DTC, FITC's likelihood for FITC; for classes log Z of gp/training/laplace_approximation.h, with
//   sigma_n fixed, s_y and s_m 1, s_d of the weighted inputs, and sigma_f at most 300
//
//   1. S: all points, or a random subset of `subset_size`
//   2. starts: the given theta, or theta_0, which follows the data, where its J is higher; then
//      `restarts` random ones
//   3. from each start gp/training/bounded_ascent.h; the best theta is the result
//
// With s_d the standard deviation of input d (1 if it is 0), s_y the root mean square of y, with a
// mean function that around the mean of each output, and s_m that around the mean in any case:
//
//                      theta_0     restarts, log-uniform     bounds
//   lengths            s_d r / 2   1/20 to 20 theta_0        [1e-4, 1e6] s_d
//   weights w_d        2 / s_d r   the same                  [1e-6, 1e4] / s_d
//   w_0 and others     1           the same                  [1e-5, 1e5]
//   sigma_f            s_y         the same                  1e-3 s_m to 1e4 s_y
//   sigma_n            s_m / 10    the same                  1e-5 s_m to 10 s_y
//
// r = sqrt(D), since the distance of two points is about s_d sqrt(2 D).
//
// The caller may give bounds for any of them; equal ones keep a value fixed. Default bounds are
// widened to include the given theta.
//
// Unless sigma_n is fixed, 1e-10 sigma_f^2 is added to sigma_n^2, in J and in the result: with less
// noise, float64 variances are lost in the rounding of sigma_f^2.
//
// If K is not positive definite, J is that of K + jitter I with the jitter with which the model
// would be conditioned (gp/linalg/not_positive_definite.h, in units of the largest k(x_i, x_i)).
//
// A sparse model's inducing inputs are chosen at the start and again where the ascent ended, until
// J, with the inputs chosen at its theta, rises by less than 0.1.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "gp/model/sparse_solution.h"
#include "kernels/runtime/context.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

struct SearchResult {
  gp::Hyperparameters hyperparameters;
  egosieve_optimize_result account{};  // without on_bound
  std::vector<int32_t> on_bound;
};

// of_classes: targets are labels, noise variances the points' weights, and sigma_n is fixed. Throws
// FailedPrecondition with fewer than 2 points, and if J is -infinity at every start; Cancelled if
// should_stop says so.
SearchResult SearchHyperparameters(
    kernels::Context& context, const gp::Hyperparameters& start, const gp::Observations& data,
    const egosieve_optimize_options& options,
    const std::optional<gp::SparseModelOptions>& sparse = std::nullopt, bool of_classes = false);

}  // namespace egosieve::embed
