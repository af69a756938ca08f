// What a prediction in float64 needs of the training points, computed in the device's memory:
//
//   sums(q, c) = sum_i k(x_q, x_i) w_ic        norms(q) = |F k_q|^2,   k_q = (k(x_q, x_i))_i
//
// F is L^-1 for a Cholesky factor L (by substitution), or the R of FactorKind::kInverseCholesky.
// Inputs, weights and factor are transferred once, a call transfers its queries and results. Cost
// per query: a covariance and w multiply-adds for each input, n^2 / 2 more for the norm; memory:
// n^2 values, and 2 n for each of a chunk's queries. Results do not depend on other queries.
#pragma once

#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Immutable: any number of threads may evaluate.
class Float64Sums {
 public:
  // inputs: n x D, n >= 1, kept by reference; weights: n x w, w >= 1; factor: n x n, the lower
  // triangle is read. InvalidArgument for other shapes; FailedPrecondition on devices without
  // float64.
  static absl::StatusOr<std::unique_ptr<const Float64Sums>> Create(
      std::shared_ptr<Context> context, const CovarianceParameters& covariance,
      ConstMatrixView<double> inputs, ConstMatrixView<double> weights, FactorKind kind,
      ConstMatrixView<double> factor);
  virtual ~Float64Sums() = default;

  // queries: M x D, finite; sums: M x w; norms: M values, null: not wanted.
  virtual absl::Status Evaluate(ConstMatrixView<double> queries, MatrixView<double> sums,
                                double* norms) const = 0;
};

}  // namespace egosieve::kernels
