#include "gp/training/marginal_likelihood.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_gradient.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

absl::Status CheckSizes(ConstMatrixView<double> x, absl::Span<const double> targets) {
  if (static_cast<int64_t>(targets.size()) != x.rows) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d inputs and %d targets", x.rows, targets.size()));
  }
  for (size_t i = 0; i < targets.size(); ++i) {
    if (!std::isfinite(targets[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("targets[%d] = %g; it must be finite", i, targets[i]));
    }
  }
  return absl::OkStatus();
}

// The lower triangle of alpha alpha^T - K_y^-1 in place of L.
void WeightsInPlaceOfFactor(const std::vector<double>& alpha, MatrixView<double> l) {
  AlignedMatrix inverse(l.rows, l.rows);
  InvertLower(l, inverse.view());
  MultiplyInverse(inverse.view(), l);
  for (int64_t i = 0; i < l.rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) l(i, j) = alpha[i] * alpha[j] - l(i, j);
  }
}

}  // namespace

absl::StatusOr<MarginalLikelihood> ComputeMarginalLikelihood(kernels::Context& context,
                                                             const Hyperparameters& hyperparameters,
                                                             ConstMatrixView<double> x,
                                                             absl::Span<const double> targets,
                                                             LikelihoodOrder order) {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckSizes(x, targets));
  const int64_t n = x.rows;
  const double noise_variance = hyperparameters.noise_variance();
  MarginalLikelihood result;
  const bool with_gradient = order == LikelihoodOrder::kValueAndGradient;
  if (n == 0) {
    if (with_gradient) result.gradient.assign(hyperparameters.count(), 0.0);
    return result;
  }

  AlignedMatrix storage(n, n);
  const MatrixView<double> k = storage.view();
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix<double>(
      context, hyperparameters.covariance, x, noise_variance, kernels::Triangle::kLower, k));
  if (const int64_t bad = FactorizeInParallel(k, PivotFloors(k, n, 1.0)); bad >= 0) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "row %d: covariances plus noise variance %g are not positive definite to working precision",
        bad, noise_variance));
  }
  std::vector<double> alpha(targets.begin(), targets.end());
  SolveLower(k, MatrixView<double>(alpha.data(), n, 1));
  SolveLowerTransposed(k, MatrixView<double>(alpha.data(), n, 1));
  double half_determinant = 0.0, fit = 0.0;
  for (int64_t i = 0; i < n; ++i) {
    half_determinant += std::log(k(i, i));
    fit += targets[i] * alpha[i];
  }
  result.value = -0.5 * fit - half_determinant - 0.5 * n * std::log(2.0 * M_PI);  // (1)
  if (!with_gradient) return result;

  WeightsInPlaceOfFactor(alpha, k);
  EGOSIEVE_ASSIGN_OR_RETURN(result.gradient,
                            kernels::CovarianceGradient(context, hyperparameters.covariance, x, k));
  for (double& component : result.gradient) component *= 0.5;  // (2)
  double trace = 0.0;
  for (int64_t i = 0; i < n; ++i) trace += k(i, i);
  result.gradient.push_back(noise_variance * trace);  // (3)
  return result;
}

}  // namespace egosieve::gp
