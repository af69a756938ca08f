#include "gp/model/sparse_model.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

absl::Status CheckOneOutput(int64_t outputs) {
  EGOSIEVE_REQUIRE(InvalidArgument, outputs == 1,
                   "targets of %d outputs; a sparse model has one: make a model for each", outputs);
  return absl::OkStatus();
}

constexpr int64_t kPredictionTile = 512;
constexpr double kReverseJitter = 1e-13;  // on the unit scale of I - A^-1; see ReverseFactor

// C lower triangular with C^T C = S, S symmetric, lower triangle read: the Cholesky factorisation
// of S with rows and columns reversed. S = I - A^-1 has eigenvalues in [0, 1); directions without
// data have 0. A jitter of some hundred eps keeps the pivots positive and changes a variance by as
// much, relative to the prior's.
bool ReverseFactor(MatrixView<double> s) {
  const int64_t m = s.rows;
  AlignedMatrix reversed(m, m);
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      reversed.row(i)[j] = s(m - 1 - j, m - 1 - i) + (i == j ? kReverseJitter : 0.0);
    }
  }
  const std::vector<double> floors(m, 0.0);
  if (FactorizeInParallel(reversed.view(), floors) >= 0) return false;
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) s(i, j) = reversed.row(m - 1 - j)[m - 1 - i];
  }
  return true;
}

absl::StatusOr<std::shared_ptr<const SparsePosteriorForm>> PosteriorFormOf(
    const SparseSolution& solution) {
  const int64_t m = solution.inducing_size();
  AlignedMatrix inverse(m, m), r(m, m), s(m, m);
  InvertLower(solution.sum_factor.view(), inverse.view());
  MultiplyInverse(inverse.view(), s.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j <= i; ++j) s.row(i)[j] = (i == j ? 1.0 : 0.0) - s.row(i)[j];
  }
  EGOSIEVE_REQUIRE(
      FailedPrecondition, ReverseFactor(s.view()),
      "I - A^-1 is not positive semidefinite to working precision; take a larger noise");
  // R = C L^-1, by rows: R L = C, R^T = L^-T C^T.
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) r.row(j)[i] = s.row(i)[j];
  }
  SolveLowerTransposed(solution.factor.view(), r.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) s.row(i)[j] = j <= i ? r.row(j)[i] : 0.0;
  }
  RegressionWeights weights;
  weights.points = m;
  weights.alpha = solution.weights;
  SolveLowerTransposed(solution.factor.view(), MatrixView<double>(weights.alpha.data(), m, 1));
  return std::make_shared<const SparsePosteriorForm>(
      SparsePosteriorForm{std::move(s), std::move(weights)});
}

}  // namespace

absl::StatusOr<SparseModel> SparseModel::Create(std::shared_ptr<kernels::Context> context,
                                                const Hyperparameters& hyperparameters,
                                                const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean("sparse", hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  SparseModel model(std::move(context), hyperparameters);
  model.options_ = options;
  return model;
}

absl::StatusOr<SparseModel> SparseModel::Restore(std::shared_ptr<kernels::Context> context,
                                                 const ExactModelState& state,
                                                 const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckOneOutput(state.points.outputs));
  EGOSIEVE_ASSIGN_OR_RETURN(SparseModel model,
                            Create(std::move(context), state.hyperparameters, options));
  model.points_ = state.points;
  EGOSIEVE_RETURN_IF_ERROR(model.Refresh());
  return model;
}

absl::Status SparseModel::AddObservations(const Observations& added, int64_t time) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(added, points_, input_dimension()));
  if (added.size() == 0) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(CheckOneOutput(added.outputs()));
  PointSet points = points_;
  points.Append(added, time);
  const int64_t k = added.size(), m = inducing_size();
  if (m == 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(solution_,
                              ChooseAndSolveSparse(*context_, options_, hyperparameters_, points));
    points_ = std::move(points);
    changes_ = 0;
    return absl::OkStatus();
  }
  if (RefreshIfStale(k, points)) return absl::OkStatus();
  AlignedMatrix v(k, m);
  std::vector<double> lambda(k);
  EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(*context_, options_, hyperparameters_, solution_,
                                         added.inputs, added.noise_variances, v.view(),
                                         lambda.data()));
  EGOSIEVE_ASSIGN_OR_RETURN(SparseSums sums,
                            SumsWith(v.view(), lambda.data(), &points.targets[size()], 1.0));
  solution_.lambda.reserve(solution_.lambda.size() + k);
  // Nothing below can fail.
  solution_.lambda.insert(solution_.lambda.end(), lambda.begin(), lambda.end());
  Commit(std::move(sums), std::move(points), k);
  return absl::OkStatus();
}

absl::Status SparseModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  PointSet points = points_;
  points.Remove(rows);
  const int64_t k = static_cast<int64_t>(rows.size()), m = inducing_size();
  if (RefreshIfStale(k, points)) return absl::OkStatus();
  std::vector<double> inputs, targets, lambda;
  for (const int64_t row : rows) {
    const double* x = &points_.inputs[row * input_dimension()];
    inputs.insert(inputs.end(), x, x + input_dimension());
    targets.push_back(points_.targets[row]);
    lambda.push_back(solution_.lambda[row]);
  }
  AlignedMatrix v(k, m);
  EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(*context_, options_, hyperparameters_, solution_,
                                         {inputs.data(), k, input_dimension()}, {}, v.view(),
                                         nullptr));
  EGOSIEVE_ASSIGN_OR_RETURN(SparseSums sums,
                            SumsWith(v.view(), lambda.data(), targets.data(), -1.0));
  // Nothing below can fail.
  EraseRows(1, rows, solution_.lambda);
  Commit(std::move(sums), std::move(points), k);
  return absl::OkStatus();
}

absl::StatusOr<SparseSums> SparseModel::SumsWith(ConstMatrixView<double> v, const double* lambda,
                                                 const double* targets, double sign) const {
  const int64_t m = inducing_size();
  SparseSums sums = {AlignedMatrix(m, m), {}, solution_.target_sum, {}};
  for (int64_t i = 0; i < m; ++i) std::copy_n(solution_.sum.row(i), m, sums.sum.row(i));
  sums.Add(v, lambda, targets, sign);
  EGOSIEVE_RETURN_IF_ERROR(sums.Solve());
  return sums;
}

void SparseModel::Commit(SparseSums sums, PointSet points, int64_t changed) {
  static_cast<SparseSums&>(solution_) = std::move(sums);
  solution_.posterior_form.reset();
  points_ = std::move(points);
  changes_ += changed;
}

bool SparseModel::RefreshIfStale(int64_t changed, PointSet& points) {
  const double limit = options_.refresh_share * static_cast<double>(points.size());
  if (!(static_cast<double>(changes_ + changed) > limit)) return false;
  absl::StatusOr<SparseSolution> solution =
      ChooseAndSolveSparse(*context_, options_, hyperparameters_, points);
  // If new inducing inputs cannot be computed, the old ones stay in use.
  if (!solution.ok()) return false;
  solution_ = *std::move(solution);
  points_ = std::move(points);
  changes_ = 0;
  return true;
}

absl::Status SparseModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean("sparse", hyperparameters));
  Hyperparameters copy = hyperparameters;
  EGOSIEVE_ASSIGN_OR_RETURN(solution_,
                            ChooseAndSolveSparse(*context_, options_, hyperparameters, points_));
  hyperparameters_ = std::move(copy);
  changes_ = 0;
  return absl::OkStatus();
}

absl::Status SparseModel::Refresh() {
  return SetHyperparameters(Hyperparameters(hyperparameters_));
}

absl::Status SparseModel::SetInducingInputs(ConstMatrixView<double> inputs) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(inputs, input_dimension()));
  EGOSIEVE_ASSIGN_OR_RETURN(
      solution_, SolveSparse(*context_, options_, hyperparameters_, points_, Widen(inputs)));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> SparseModel::PredictMean(ConstMatrixView<double> points) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  const int64_t m = inducing_size();
  std::vector<double> mean;
  for (int64_t begin = 0; begin < points.rows; begin += kPredictionTile) {
    const ConstMatrixView<double> tile =
        points.rows_between(begin, std::min(begin + kPredictionTile, points.rows));
    AlignedMatrix v(tile.rows, m);
    EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(*context_, options_, hyperparameters_, solution_, tile,
                                           {}, v.view(), nullptr));
    for (int64_t i = 0; i < tile.rows; ++i) {
      mean.push_back(Dot(v.row(i), solution_.weights.data(), m));  // (SP4)
    }
  }
  return mean;
}

double SparseModel::LogMarginalLikelihood() const {
  double sum = static_cast<double>(size()) * std::log(2.0 * M_PI);
  for (int64_t j = 0; j < inducing_size(); ++j) {
    sum += 2.0 * std::log(solution_.sum_factor.row(j)[j]) -
           solution_.target_sum[j] * solution_.weights[j];
  }
  for (int64_t i = 0; i < size(); ++i) {
    sum += std::log(solution_.lambda[i]) +
           points_.targets[i] * points_.targets[i] / solution_.lambda[i];
  }
  return -0.5 * sum;
}

absl::StatusOr<LeaveOneOut> SparseModel::PredictLeaveOneOut() const {
  // (Q + Lambda)^-1 = Lambda^-1 - Lambda^-1 V A^-1 V^T Lambda^-1; the rows of V are v_i.
  LeaveOneOut result;
  result.noise_variances = points_.noise_variances;
  const int64_t n = size(), m = inducing_size();
  std::vector<double> mean;
  for (int64_t begin = 0; begin < n; begin += kPredictionTile) {
    const int64_t rows = std::min(kPredictionTile, n - begin);
    AlignedMatrix half(rows, m);
    EGOSIEVE_RETURN_IF_ERROR(
        ProjectPoints(*context_, options_, hyperparameters_, solution_,
                      points_.view(input_dimension()).rows_between(begin, begin + rows), {},
                      half.view(), nullptr));
    for (int64_t i = 0; i < rows; ++i) {
      mean.push_back(Dot(half.row(i), solution_.weights.data(), m));
    }
    AppendRows(solution_.sum_factor.view(), half.view());
    for (int64_t i = 0; i < rows; ++i) {
      const int64_t row = begin + i;
      const double inverse =
          (1.0 - Square(half.row(i), m) / solution_.lambda[row]) / solution_.lambda[row];
      const double alpha = (points_.targets[row] - mean[row]) / solution_.lambda[row];
      result.rows.push_back(row);
      result.mean.push_back(points_.targets[row] - alpha / inverse);
      result.target_variance.push_back(1.0 / inverse);
    }
  }
  return result;
}

absl::StatusOr<RegressionModel::PosteriorParts> SparseModel::Parts() const {
  if (solution_.posterior_form == nullptr) {
    EGOSIEVE_ASSIGN_OR_RETURN(solution_.posterior_form, PosteriorFormOf(solution_));
  }
  const std::shared_ptr<const SparsePosteriorForm>& form = solution_.posterior_form;
  return PosteriorParts{inducing_inputs(),
                        &form->weights,
                        {kernels::FactorKind::kInverseCholesky, form->root.view(), form}};
}

absl::StatusOr<std::shared_ptr<const SamplePaths>> SparseModel::DrawPaths(
    const PathOptions& options) const {
  const ConstMatrixView<double> u = inducing_inputs();
  EGOSIEVE_ASSIGN_OR_RETURN(PriorPaths prior, PriorPaths::Draw(hyperparameters_, u, 1, options));
  const int64_t m = u.rows, columns = prior.columns();
  std::vector<double> values(m * columns), g(m), v(m);
  prior.AddTo(u, {values.data(), m, columns});
  RegressionWeights update;
  update.points = m;
  update.outputs = columns;
  update.alpha.resize(m * columns);
  for (int64_t c = 0; c < columns; ++c) {  // one by one: its bits are its own
    NormalStream normal = prior.Numbers(c);
    for (int64_t i = 0; i < m; ++i) {
      g[i] = values[i * columns + c] + std::sqrt(solution_.jitter) * normal();
      v[i] = normal();
    }
    SolveLower(solution_.factor.view(), MatrixView<double>(g.data(), m, 1));
    SolveLowerTransposed(solution_.sum_factor.view(), MatrixView<double>(v.data(), m, 1));
    for (int64_t i = 0; i < m; ++i) v[i] += solution_.weights[i] - g[i];
    SolveLowerTransposed(solution_.factor.view(), MatrixView<double>(v.data(), m, 1));
    for (int64_t i = 0; i < m; ++i) update.alpha[i * columns + c] = v[i];
  }
  return std::make_shared<const SamplePaths>(context_, hyperparameters_, u, std::move(prior),
                                             update, options.of_observation);
}

}  // namespace egosieve::gp
