// Maximises the log marginal likelihood from given hyperparameters until convergence, for programs
// that fit one model. In contrast, gp/training/hyperparameter_trainer.h follows a stream of data.
//
//   J(theta) = log p(y_S | X_S, theta) / |S|,   theta = logarithms of scales, sigma_f, sigma_n
//
//   for a sparse model the objective of gp/training/sparse_likelihood.h instead of log p: VFE for
//   DTC, FITC's likelihood for FITC, inducing inputs chosen at the start
//
//   1. S: all points, or a random subset of `subset_size`
//   2. simulated annealing, if asked for                    gp/training/simulated_annealing.h
//   3. iRprop- from the best theta                          gp/training/gradient_ascent.h
//
// The bounds follow the data. s_d is the standard deviation of input d (1 if it is 0), s_y the root
// mean square of y, with a mean function that around the mean of each output. The bounds are
// widened to include the start:
//
//   arcsine w_0 in [0.01, 100], w_d in [0.01, 1000] / s_d;   l_d in [0.01, 100] s_d
//   sigma_f in [0.1, 10] s_y;   sigma_n in [0.01, 2] s_y
//
// For data without noise, sigma_f rises and sigma_n falls without end, and with them rises the
// error of float32 means, about sqrt(n) 1e-7 sigma_f^2 / sigma_n. At the corner of the bounds, for
// n = 100, it equals sigma_n.
//
// If K is not positive definite after a step, the step is undone and all step sizes are halved. The
// result is the best theta seen, so J never decreases.
#ifndef EGOSIEVE_TOOLS_EMBED_C_HYPERPARAMETER_SEARCH_H_
#define EGOSIEVE_TOOLS_EMBED_C_HYPERPARAMETER_SEARCH_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "gp/model/sparse_solution.h"
#include "gp/training/sparse_likelihood.h"
#include "kernels/runtime/context.h"

namespace egosieve::embed {

struct SearchOptions {
  int64_t subset_size = 800;      // points; 0: all
  int annealing_evaluations = 0;  // number of evaluations of J
  int gradient_steps = 100;       // largest number of steps
  double tolerance = 1e-3;        // ends when the largest step of theta falls below it
  uint64_t seed = 1;

  absl::Status Validate() const;
};

struct SearchResult {
  gp::Hyperparameters hyperparameters;
  double log_likelihood_at_start = 0.0;  // of S, nats
  double log_likelihood = 0.0;
  int64_t evaluations = 0;
  int64_t points = 0;  // |S|
  bool converged = false;
};

gp::HyperparameterBounds BoundsForData(const gp::Hyperparameters& kind,
                                       const gp::Observations& data);

// FailedPrecondition with fewer than 2 points.
absl::StatusOr<SearchResult> SearchHyperparameters(
    kernels::Context& context, const gp::Hyperparameters& start, const gp::Observations& data,
    const SearchOptions& options,
    const std::optional<gp::SparseModelOptions>& sparse = std::nullopt);

// The objective for training a sparse model with these options.
gp::SparseLikelihoodOptions SparseObjectiveOf(const gp::SparseModelOptions& options);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_HYPERPARAMETER_SEARCH_H_
