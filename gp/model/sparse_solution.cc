#include "gp/model/sparse_solution.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/jitter_sequence.h"
#include "gp/linalg/lower_tiles.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/linalg/tile_operations.h"
#include "gp/model/inducing_points.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kInducingTile = 128;

void SetIdentity(MatrixView<double> a) {
  for (int64_t i = 0; i < a.rows; ++i) {
    std::fill(a.row(i), a.row(i) + a.cols, 0.0);
    a(i, i) = 1.0;
  }
}

// Factor of K_uu with the first jitter that works.
absl::Status FactorizeInducing(kernels::Context& context, const SparseModelOptions& options,
                               const Hyperparameters& hyperparameters, SparseSolution& solution) {
  const int64_t dimension = hyperparameters.covariance.input_dimension();
  const int64_t m = static_cast<int64_t>(solution.inducing_inputs.size()) / dimension;
  const ConstMatrixView<double> u(solution.inducing_inputs.data(), m, dimension);
  const double signal_stddev = hyperparameters.covariance.signal_stddev;
  const double unit = signal_stddev * signal_stddev;
  solution.factor = AlignedMatrix(m, m);
  const MatrixView<double> k = solution.factor.view();
  solution.jitter = options.relative_jitter * hyperparameters.noise_variance();
  while (true) {
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix<double>(
        context, hyperparameters.covariance, u, solution.jitter, kernels::Triangle::kLower, k));
    const int64_t bad = FactorizeInParallel(k, PivotFloors(k, m, 1.0));
    if (bad < 0) return absl::OkStatus();
    const std::optional<double> next = NextJitter(solution.jitter, unit);
    if (!next.has_value()) {
      return NotPositiveDefinite(
          absl::StrFormat("inducing input %d is explained by those before it to working precision; "
                          "jitter up to %g did not help",
                          bad, solution.jitter));
    }
    solution.jitter = *next;
  }
}

}  // namespace

absl::Status SparseModelOptions::Validate() const {
  if (!(inducing_points >= 1)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("inducing_points = %d; it must be positive", inducing_points));
  }
  if (!(refresh_share >= 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("refresh_share = %g; it must not be negative", refresh_share));
  }
  if (!(relative_jitter >= 0.0 && std::isfinite(relative_jitter))) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "relative_jitter = %g; it must be finite and not negative", relative_jitter));
  }
  return absl::OkStatus();
}

void AddTerms(ConstMatrixView<double> v, const double* lambda, double sign, MatrixView<double> a) {
  const int64_t m = a.rows;
  AlignedMatrix scaled(v.rows, m);
  for (int64_t i = 0; i < v.rows; ++i) {
    for (int64_t j = 0; j < m; ++j) scaled.row(i)[j] = sign * v(i, j) / lambda[i];
  }
  const auto add = [&](int64_t row, int64_t column, int64_t rows, int64_t columns) {
    tile::AddTransposedProduct(
        tile::Block(v, 0, row, v.rows, rows),
        tile::Block(ConstMatrixView<double>(scaled.view()), 0, column, v.rows, columns),
        tile::Block(a, row, column, rows, columns));
  };
  ForEachLowerTile(m, kInducingTile, 1.0 * m * m * v.rows, add);
}

void AddTargetTerms(const double* v, const double* lambda, const double* targets, int64_t count,
                    std::vector<double>& c) {
  const int64_t m = static_cast<int64_t>(c.size());
  for (int64_t i = 0; i < count; ++i) {
    const double scale = targets[i] / lambda[i];
    for (int64_t j = 0; j < m; ++j) c[j] += scale * v[i * m + j];
  }
}

absl::StatusOr<AlignedMatrix> FactorOfSum(const AlignedMatrix& sum) {
  AlignedMatrix factor(sum.rows(), sum.rows());
  for (int64_t i = 0; i < sum.rows(); ++i) std::copy_n(sum.row(i), i + 1, factor.row(i));
  if (FactorizeInParallel(factor.view(), std::vector<double>(sum.rows(), 0.0)) >= 0) {
    return absl::FailedPreconditionError(
        "I + V^T V / lambda is not positive definite to working precision; take a larger noise");
  }
  return factor;
}

void SolveSum(const AlignedMatrix& sum_factor, std::vector<double>& c) {
  const MatrixView<double> column(c.data(), sum_factor.rows(), 1);
  SolveLower(sum_factor.view(), column);
  SolveLowerTransposed(sum_factor.view(), column);
}

AlignedMatrix CopyOfSum(const AlignedMatrix& sum) {
  AlignedMatrix copy(sum.rows(), sum.cols());
  for (int64_t i = 0; i < sum.rows(); ++i) std::copy_n(sum.row(i), sum.cols(), copy.row(i));
  return copy;
}

absl::StatusOr<SparseSolution> ChooseAndSolveSparse(kernels::Context& context,
                                                    const SparseModelOptions& options,
                                                    const Hyperparameters& hyperparameters,
                                                    const PointSet& points) {
  if (points.size() == 0) return SolveSparse(context, options, hyperparameters, points, {});
  EGOSIEVE_ASSIGN_OR_RETURN(
      std::vector<double> inputs,
      ChooseInducingInputs(context, hyperparameters.covariance,
                           points.view(hyperparameters.covariance.input_dimension()),
                           options.inducing_points));
  return SolveSparse(context, options, hyperparameters, points, std::move(inputs));
}

absl::StatusOr<SparseSolution> SolveSparse(kernels::Context& context,
                                           const SparseModelOptions& options,
                                           const Hyperparameters& hyperparameters,
                                           const PointSet& points, std::vector<double> inputs) {
  SparseSolution solution;
  solution.inducing_inputs = std::move(inputs);
  EGOSIEVE_RETURN_IF_ERROR(FactorizeInducing(context, options, hyperparameters, solution));
  const int64_t m = solution.factor.rows(), n = points.size();
  AlignedMatrix v(n, m);
  EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(context, options, hyperparameters, solution,
                                         points.view(hyperparameters.covariance.input_dimension()),
                                         points.noise_variances, v, solution.lambda));
  solution.projections.reserve(n * m);
  for (int64_t i = 0; i < n; ++i) {
    solution.projections.insert(solution.projections.end(), v.row(i), v.row(i) + m);
  }
  solution.sum = AlignedMatrix(m, m);
  SetIdentity(solution.sum.view());
  AddTerms(v.view(), solution.lambda.data(), 1.0, solution.sum.view());
  EGOSIEVE_ASSIGN_OR_RETURN(solution.sum_factor, FactorOfSum(solution.sum));
  solution.weights.assign(m, 0.0);
  AddTargetTerms(solution.projections.data(), solution.lambda.data(), points.targets.data(), n,
                 solution.weights);
  SolveSum(solution.sum_factor, solution.weights);
  return solution;
}

absl::Status ProjectPoints(kernels::Context& context, const SparseModelOptions& options,
                           const Hyperparameters& hyperparameters, const SparseSolution& solution,
                           ConstMatrixView<double> inputs, absl::Span<const double> noise_variances,
                           AlignedMatrix& v, std::vector<double>& lambda) {
  const int64_t m = solution.factor.rows();
  lambda.assign(inputs.rows, hyperparameters.noise_variance());
  for (size_t i = 0; i < noise_variances.size(); ++i) lambda[i] += noise_variances[i];
  if (m == 0) return absl::OkStatus();
  const ConstMatrixView<double> inducing(solution.inducing_inputs.data(), m,
                                         hyperparameters.covariance.input_dimension());
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(context, hyperparameters.covariance,
                                                            inputs, inducing, v.view()));
  AppendRows(solution.factor.view(), v.view());  // (SP1)
  if (options.approximation != SparseApproximation::kFitc) return absl::OkStatus();
  for (int64_t i = 0; i < inputs.rows; ++i) {  // (SP2)
    const double prior = PriorVariance(hyperparameters.covariance, inputs.row(i));
    lambda[i] += std::max(0.0, prior - Square(v.row(i), m));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
