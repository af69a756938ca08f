#include "gp/training/marginal_likelihood.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/exact_regression.h"

namespace egosieve::gp {
namespace {

using kernels::MatrixView;

// Replaces L by the lower triangle of sum_c alpha_c alpha_c^T - k P.
void WeightsInPlaceOfFactor(const RegressionWeights& weights, MatrixView<double> l) {
  AlignedMatrix inverse(l.rows, l.rows);
  InvertLower(l, inverse.view());
  MultiplyInverse(inverse.view(), l);
  const int64_t k = weights.outputs, q = weights.basis;
  const std::vector<double> reduced = weights.ReducedRows();
  for (int64_t i = 0; i < l.rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      double products = 0.0, p = l(i, j);
      for (int64_t c = 0; c < k; ++c)
        products += weights.alpha[i * k + c] * weights.alpha[j * k + c];
      for (int64_t c = 0; c < q; ++c) p -= reduced[i * q + c] * reduced[j * q + c];
      l(i, j) = products - static_cast<double>(k) * p;
    }
  }
}

// What kernels/ops/exact_regression.h computes, on the host; with a mean function M's determinant is
// part of L's.
absl::StatusOr<kernels::ExactRegression> RegressOnHost(kernels::Context& context,
                                                       const Hyperparameters& hyperparameters,
                                                       const Observations& data,
                                                       bool with_gradient) {
  const int64_t n = data.size(), outputs = data.outputs();
  AlignedMatrix storage(n, n);
  const MatrixView<double> k = storage.view();
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(context, hyperparameters.covariance,
                                                     data.inputs, hyperparameters.noise_variance(),
                                                     kernels::Triangle::kLower, k));
  for (int64_t i = 0; i < n; ++i) k(i, i) += data.noise_variance(i);
  kernels::ExactRegression result;
  result.bad_row = FactorizeInParallel(k, PivotFloors(k, n, 1.0));
  if (result.bad_row >= 0) return result;
  const RegressionWeights weights =
      SolveWeights(k, hyperparameters.mean, data.inputs, data.targets);
  EGOSIEVE_RETURN_IF_ERROR(weights.CheckDetermined());
  result.half_log_determinant = weights.HalfLogDeterminant();
  for (int64_t i = 0; i < n; ++i) {
    result.half_log_determinant += std::log(k(i, i));
    for (int64_t c = 0; c < outputs; ++c) {
      result.fit += data.targets(i, c) * weights.alpha[i * outputs + c];
    }
  }
  if (!with_gradient) return result;
  WeightsInPlaceOfFactor(weights, k);
  EGOSIEVE_ASSIGN_OR_RETURN(
      result.gradient,
      kernels::CovarianceGradient(context, hyperparameters.covariance, data.inputs, k));
  for (int64_t i = 0; i < n; ++i) result.trace += k(i, i);
  return result;
}

}  // namespace

absl::StatusOr<MarginalLikelihood> ComputeMarginalLikelihood(kernels::Context& context,
                                                             const Hyperparameters& hyperparameters,
                                                             const Observations& data,
                                                             LikelihoodOrder order) {
  const int64_t dimension = hyperparameters.covariance.input_dimension();
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(data.Validate(dimension));
  const double noise_variance = hyperparameters.noise_variance();
  MarginalLikelihood result;
  const bool with_gradient = order == LikelihoodOrder::kValueAndGradient;
  if (data.size() == 0) {
    if (with_gradient) result.gradient.assign(hyperparameters.count(), 0.0);
    return result;
  }
  const bool on_device =
      hyperparameters.mean == MeanFunction::kZero && kernels::RegressesOnDevice(context);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const kernels::ExactRegression regression,
      on_device
          ? kernels::RegressOnDevice(context, hyperparameters.covariance, data.inputs, data.targets,
                                     noise_variance, data.noise_variances, with_gradient)
          : RegressOnHost(context, hyperparameters, data, with_gradient));
  if (regression.bad_row >= 0) {
    return NotPositiveDefinite(absl::StrFormat(
        "row %d: covariances plus noise variance %g are not positive definite to working precision",
        regression.bad_row, noise_variance));
  }
  const double count =
      static_cast<double>(data.size() - CoefficientCount(hyperparameters.mean, dimension));
  result.value = -0.5 * regression.fit -
                 static_cast<double>(data.outputs()) *
                     (regression.half_log_determinant + 0.5 * count * std::log(2.0 * M_PI));  // (1)
  if (!with_gradient) return result;
  result.gradient = regression.gradient;
  for (double& component : result.gradient) component *= 0.5;    // (2)
  result.gradient.push_back(noise_variance * regression.trace);  // (3)
  return result;
}

}  // namespace egosieve::gp
