// The posterior of a Gaussian process at one moment, computed in float64 on the host; covariances
// on the device, if it has float64.
//
//   mean, variance   (W3), (W4) of gp/model/regression_weights.h for a factor L, and with |R k*|^2
//                    in place of |L^-1 k*|^2 for the R of a sparse model
//
// It shares the model's factor: see IncrementalCholesky::Keep. Cost per query: n (D + 10 + k)
// multiply-adds for the mean, n^2 / 2 more for the variance; memory: inputs and
// weights, and tiles of 768 n values during a call. A query's result does not depend on other
// queries or threads. Immutable: any number of threads may evaluate.
#ifndef EGOSIEVE_GP_MODEL_FLOAT64_POSTERIOR_H_
#define EGOSIEVE_GP_MODEL_FLOAT64_POSTERIOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// L or R, n x n, and what keeps it in memory.
struct SharedFactor {
  kernels::FactorKind kind = kernels::FactorKind::kCholesky;
  kernels::ConstMatrixView<double> values;
  std::shared_ptr<const void> memory;
};

class Float64Posterior {
 public:
  // inputs: n x D, copied. `weights` must be determined.
  Float64Posterior(std::shared_ptr<kernels::Context> context,
                   const Hyperparameters& hyperparameters, kernels::ConstMatrixView<double> inputs,
                   const RegressionWeights& weights, SharedFactor factor);

  // queries: M x D, finite, else InvalidArgument; means: M x k; variances of f: M; null: not
  // wanted. Gives the number of variances that were negative from rounding and are 0.
  absl::StatusOr<int64_t> Evaluate(kernels::ConstMatrixView<double> queries, double* means,
                                   double* variances) const;

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  kernels::ConstMatrixView<double> inputs() const {
    return {inputs_.data(), factor_.values.rows, hyperparameters_.covariance.input_dimension()};
  }
  int64_t outputs() const { return weights_.outputs; }

 private:
  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  std::vector<double> inputs_;
  RegressionWeights weights_;
  SharedFactor factor_;
};

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_FLOAT64_POSTERIOR_H_
