#include "gp/model/sparse_solution.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/linalg/tile_operations.h"
#include "gp/model/inducing_points.h"
#include "kernels/base/argument_checks.h"
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
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(
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
  return kernels::CheckOptions({
      {"inducing_points", inducing_points, inducing_points >= 1, "be positive"},
      {"refresh_share", refresh_share, refresh_share >= 0.0, "not be negative"},
      {"relative_jitter", relative_jitter, kernels::IsNotNegative(relative_jitter),
       "be finite and not negative"},
  });
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

void SparseSums::Add(ConstMatrixView<double> v, const double* lambda, const double* targets,
                     double sign) {
  AddTerms(v, lambda, sign, sum.view());
  for (int64_t i = 0; i < v.rows; ++i) {
    const double scale = sign * targets[i] / lambda[i];
    for (int64_t j = 0; j < v.cols; ++j) target_sum[j] += scale * v(i, j);
  }
}

absl::Status SparseSums::Solve() {
  sum_factor = AlignedMatrix(sum.rows(), sum.rows());
  for (int64_t i = 0; i < sum.rows(); ++i) std::copy_n(sum.row(i), i + 1, sum_factor.row(i));
  EGOSIEVE_REQUIRE(
      FailedPrecondition,
      FactorizeInParallel(sum_factor.view(), std::vector<double>(sum.rows(), 0.0)) < 0,
      "I + V^T V / lambda is not positive definite to working precision; take a larger noise");
  weights = target_sum;
  SolveSum(sum_factor, weights);
  return absl::OkStatus();
}

void SolveSum(const AlignedMatrix& sum_factor, std::vector<double>& c) {
  const MatrixView<double> column(c.data(), sum_factor.rows(), 1);
  SolveLower(sum_factor.view(), column);
  SolveLowerTransposed(sum_factor.view(), column);
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
                                           const PointSet& points, std::vector<double> inputs,
                                           AlignedMatrix* projections) {
  SparseSolution solution;
  solution.inducing_inputs = std::move(inputs);
  EGOSIEVE_RETURN_IF_ERROR(FactorizeInducing(context, options, hyperparameters, solution));
  const int64_t m = solution.factor.rows(), n = points.size();
  const Observations data = points.observations(hyperparameters.covariance.input_dimension());
  AlignedMatrix own;
  if (projections == nullptr) own = AlignedMatrix(std::min(kRowTile, n), m);
  if (projections != nullptr) *projections = AlignedMatrix(n, m);
  solution.lambda.resize(n);
  solution.sum = AlignedMatrix(m, m);
  SetIdentity(solution.sum.view());
  solution.target_sum.assign(m, 0.0);
  for (int64_t begin = 0; begin < n; begin += kRowTile) {
    const int64_t rows = std::min(kRowTile, n - begin);
    const MatrixView<double> v = projections == nullptr
                                     ? own.block(rows, m)
                                     : tile::Block(projections->view(), begin, 0, rows, m);
    double* lambda = &solution.lambda[begin];
    EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(
        context, options, hyperparameters, solution, data.inputs.rows_between(begin, begin + rows),
        data.noise_variances.empty() ? data.noise_variances
                                     : data.noise_variances.subspan(begin, rows),
        v, lambda));
    solution.Add(v, lambda, &points.targets[begin], 1.0);
  }
  EGOSIEVE_RETURN_IF_ERROR(solution.Solve());
  return solution;
}

absl::Status ProjectPoints(kernels::Context& context, const SparseModelOptions& options,
                           const Hyperparameters& hyperparameters, const SparseSolution& solution,
                           ConstMatrixView<double> inputs, absl::Span<const double> noise_variances,
                           MatrixView<double> v, double* lambda) {
  const int64_t m = solution.factor.rows();
  for (int64_t i = 0; lambda != nullptr && i < inputs.rows; ++i) {
    lambda[i] =
        hyperparameters.noise_variance() + (noise_variances.empty() ? 0.0 : noise_variances[i]);
  }
  if (m == 0) return absl::OkStatus();
  const ConstMatrixView<double> inducing(solution.inducing_inputs.data(), m,
                                         hyperparameters.covariance.input_dimension());
  EGOSIEVE_RETURN_IF_ERROR(
      kernels::CrossCovariance(context, hyperparameters.covariance, inputs, inducing, v));
  AppendRows(solution.factor.view(), v);  // (SP1)
  if (lambda == nullptr || options.approximation != SparseApproximation::kFitc) {
    return absl::OkStatus();
  }
  for (int64_t i = 0; i < inputs.rows; ++i) {  // (SP2)
    const double prior = PriorVariance(hyperparameters.covariance, inputs.row(i));
    lambda[i] += std::max(0.0, prior - Square(v.row(i), m));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
