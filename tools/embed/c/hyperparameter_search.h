// Maximises the log marginal likelihood from given hyperparameters to convergence: what a program
// that fits one model needs, where gp/training/hyperparameter_trainer.h follows a stream.
//
//   J(theta) = log p(y_S | X_S, theta) / |S|,   theta = logarithms of scales, sigma_f, sigma_n
//
//   of a sparse model the objective of gp/training/sparse_likelihood.h in place of log p: VFE for
//   DTC, FITC's likelihood for FITC, inducing inputs chosen at the start
//
//   1. S: all points, or a random subset of `subset_size`
//   2. annealing, where asked for                           gp/training/simulated_annealing.h
//   3. iRprop- from the best theta                          gp/training/gradient_ascent.h
//
// Bounds follow the data, s_d the standard deviation of input d (1 where it is 0), s_y the root
// mean square of y, and are widened to hold the start:
//
//   (with a mean function, around the mean of each output):
//
//   arcsine w_0 in [0.01, 100], w_d in [0.01, 1000] / s_d;   l_d in [0.01, 100] s_d
//   sigma_f in [0.1, 10] s_y;   sigma_n in [0.01, 2] s_y
//
// Data without noise drive sigma_f up and sigma_n down without end, and with them the error of
// float32 means, about sqrt(n) 1e-7 sigma_f^2 / sigma_n: at the corner of the bounds, n = 100, it
// equals sigma_n.
//
// A step to where K is not positive definite is taken back and all steps are halved. The best theta
// seen is the result, so that J never falls.
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
  int annealing_evaluations = 0;  // of J
  int gradient_steps = 100;       // at most
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

// What trains a sparse model of these options.
gp::SparseLikelihoodOptions SparseObjectiveOf(const gp::SparseModelOptions& options);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_HYPERPARAMETER_SEARCH_H_
