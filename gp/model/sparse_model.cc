#include "gp/model/sparse_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/tile_operations.h"
#include "gp/model/model_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kTile = 128;
constexpr int64_t kPredictionTile = 512;
constexpr double kReverseJitter = 1e-13;  // of I - A^-1's unit scale; see ReverseFactor

double Dot(const double* a, const double* b, int64_t n) {
  double sum = 0.0;
  for (int64_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

double Square(const double* row, int64_t n) { return Dot(row, row, n); }

// A += sign sum_i v_i v_i^T / lambda_i, the lower triangle's tiles. v: k x m.
void AddTerms(ConstMatrixView<double> v, const double* lambda, double sign, MatrixView<double> a) {
  const int64_t m = a.rows;
  AlignedMatrix scaled(v.rows, m);
  for (int64_t i = 0; i < v.rows; ++i) {
    for (int64_t j = 0; j < m; ++j) scaled.row(i)[j] = sign * v(i, j) / lambda[i];
  }
  const int64_t tiles = (m + kTile - 1) / kTile;
  kernels::ParallelFor(tiles * (tiles + 1) / 2, 1.0 * m * m * v.rows, [&](int64_t t) {
    int64_t i = 0;
    while ((i + 1) * (i + 2) / 2 <= t) ++i;
    const int64_t row = i * kTile, column = (t - i * (i + 1) / 2) * kTile;
    const int64_t rows = std::min(kTile, m - row), columns = std::min(kTile, m - column);
    tile::AddTransposedProduct(
        tile::Block(v, 0, row, v.rows, rows),
        tile::Block(ConstMatrixView<double>(scaled.view()), 0, column, v.rows, columns),
        tile::Block(a, row, column, rows, columns));
  });
}

void SetIdentity(MatrixView<double> a) {
  for (int64_t i = 0; i < a.rows; ++i) {
    std::fill(a.row(i), a.row(i) + a.cols, 0.0);
    a(i, i) = 1.0;
  }
}

// C lower triangular with C^T C = S, S symmetric, lower triangle read: the Cholesky factorisation
// of S with rows and columns reversed. S = I - A^-1 has eigenvalues in [0, 1), those of directions
// that the data say nothing about being 0; a jitter of some hundred eps keeps the pivots positive
// and changes a variance by as much, relative to the prior's.
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

absl::StatusOr<SparseModel> SparseModel::Create(std::shared_ptr<kernels::Context> context,
                                                const Hyperparameters& hyperparameters,
                                                const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  SparseModel model;
  model.context_ = std::move(context);
  model.hyperparameters_ = hyperparameters;
  model.options_ = options;
  return model;
}

absl::StatusOr<SparseModel> SparseModel::Restore(std::shared_ptr<kernels::Context> context,
                                                 const ExactModelState& state,
                                                 const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(SparseModel model,
                            Create(std::move(context), state.hyperparameters, options));
  model.points_ = state.points;
  EGOSIEVE_RETURN_IF_ERROR(model.Refresh());
  return model;
}

absl::Status SparseModel::Add(ConstMatrixView<float> inputs, absl::Span<const double> labels,
                              int64_t frame) {
  const std::vector<double> wide = Widen(inputs);
  return Add(ConstMatrixView<double>(wide.data(), inputs.rows, inputs.cols), labels, frame);
}

absl::Status SparseModel::Add(ConstMatrixView<double> inputs, absl::Span<const double> labels,
                              int64_t frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, TargetsOfLabels(labels));
  return AddTargets(inputs, targets, frame);
}

absl::Status SparseModel::AddTargets(ConstMatrixView<double> inputs,
                                     absl::Span<const double> targets, int64_t frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(inputs, targets, input_dimension()));
  if (inputs.rows == 0) return absl::OkStatus();
  const int64_t m = inducing_size();
  if (m == 0) {
    const PointSet before = points_;
    points_.Append(inputs, targets, frame);
    absl::Status status = Refresh();
    if (!status.ok()) points_ = before;
    return status;
  }
  AlignedMatrix v(inputs.rows, m);
  std::vector<double> lambda;
  EGOSIEVE_RETURN_IF_ERROR(Project(inputs, v, lambda));
  AddTerms(v.view(), lambda.data(), 1.0, sum_.view());
  for (int64_t i = 0; i < inputs.rows; ++i) {
    projections_.insert(projections_.end(), v.row(i), v.row(i) + m);
  }
  lambda_.insert(lambda_.end(), lambda.begin(), lambda.end());
  points_.Append(inputs, targets, frame);
  return FinishUpdate(inputs.rows);
}

absl::Status SparseModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  const int64_t m = inducing_size();
  AlignedMatrix v(static_cast<int64_t>(rows.size()), m);
  std::vector<double> lambda;
  for (size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(projections_.begin() + rows[i] * m, m, v.row(static_cast<int64_t>(i)));
    lambda.push_back(lambda_[rows[i]]);
  }
  AddTerms(v.view(), lambda.data(), -1.0, sum_.view());
  EraseRows(m, rows, projections_);
  EraseRows(1, rows, lambda_);
  points_.Remove(rows);
  return FinishUpdate(static_cast<int64_t>(rows.size()));
}

absl::Status SparseModel::FinishUpdate(int64_t changed) {
  changes_ += changed;
  const bool stale = static_cast<double>(changes_) > options_.refresh_share * size();
  // The old inducing inputs serve on where new ones cannot be had.
  return stale && Refresh().ok() ? absl::OkStatus() : UpdateWeights();
}

absl::Status SparseModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  const Hyperparameters before = std::exchange(hyperparameters_, hyperparameters);
  absl::Status status = Refresh();
  if (!status.ok()) hyperparameters_ = before;
  return status;
}

absl::Status SparseModel::Refresh() {
  if (size() == 0) return UseInducingInputs({});
  EGOSIEVE_ASSIGN_OR_RETURN(
      std::vector<double> inputs,
      ChooseInducingInputs(*context_, hyperparameters_.covariance, points_.view(input_dimension()),
                           options_.inducing_points, options_.choice, options_.seed));
  EGOSIEVE_RETURN_IF_ERROR(UseInducingInputs(std::move(inputs)));
  changes_ = 0;
  return absl::OkStatus();
}

absl::Status SparseModel::SetInducingInputs(ConstMatrixView<double> inputs) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(inputs, input_dimension()));
  std::vector<double> copy;
  for (int64_t i = 0; i < inputs.rows; ++i) {
    copy.insert(copy.end(), inputs.row(i), inputs.row(i) + inputs.cols);
  }
  return UseInducingInputs(std::move(copy));
}

absl::Status SparseModel::UseInducingInputs(std::vector<double> inputs) {
  const int64_t dimension = input_dimension();
  const int64_t m = static_cast<int64_t>(inputs.size()) / dimension;
  AlignedMatrix factor(m, m);
  const ConstMatrixView<double> u(inputs.data(), m, dimension);
  const double jitter = options_.relative_jitter * hyperparameters_.noise_variance();
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix<double>(
      *context_, hyperparameters_.covariance, u, jitter, kernels::Triangle::kLower, factor.view()));
  if (const int64_t bad = FactorizeInParallel(factor.view(), PivotFloors(factor.view(), m, 1.0));
      bad >= 0) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "inducing input %d is explained by those before it to working precision; use fewer, or a "
        "larger relative_jitter",
        bad));
  }
  std::swap(factor_, factor);
  std::swap(inducing_inputs_, inputs);
  AlignedMatrix v(size(), m);
  std::vector<double> lambda;
  if (absl::Status status = Project(points_.view(dimension), v, lambda); !status.ok()) {
    std::swap(factor_, factor);
    std::swap(inducing_inputs_, inputs);
    return status;
  }
  lambda_ = std::move(lambda);
  projections_.clear();
  for (int64_t i = 0; i < size(); ++i) {
    projections_.insert(projections_.end(), v.row(i), v.row(i) + m);
  }
  sum_ = AlignedMatrix(m, m);
  SetIdentity(sum_.view());
  AddTerms(v.view(), lambda_.data(), 1.0, sum_.view());
  return UpdateWeights();
}

absl::Status SparseModel::Project(ConstMatrixView<double> inputs, AlignedMatrix& v,
                                  std::vector<double>& lambda) const {
  const int64_t m = inducing_size();
  lambda.assign(inputs.rows, hyperparameters_.noise_variance());
  if (m == 0) return absl::OkStatus();
  const ConstMatrixView<double> inducing = inducing_inputs();
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(*context_, hyperparameters_.covariance,
                                                            inputs, inducing, v.view()));
  AppendRows(factor_.view(), v.view());  // (S1)
  if (options_.approximation != SparseApproximation::kFitc) return absl::OkStatus();
  for (int64_t i = 0; i < inputs.rows; ++i) {  // (S2)
    const double prior = PriorVariance(hyperparameters_.covariance, inputs.row(i));
    lambda[i] += std::max(0.0, prior - Square(v.row(i), m));
  }
  return absl::OkStatus();
}

// L_A and A^-1 c.
absl::Status SparseModel::UpdateWeights() {
  const int64_t m = inducing_size();
  sum_factor_ = AlignedMatrix(m, m);
  for (int64_t i = 0; i < m; ++i) std::copy_n(sum_.row(i), i + 1, sum_factor_.row(i));
  // A's eigenvalues are at least 1, so its factorisation can only fail on what is not a number.
  if (FactorizeInParallel(sum_factor_.view(), std::vector<double>(m, 0.0)) >= 0) {
    return absl::InternalError("I + V^T V / lambda is not positive definite");
  }
  weights_.assign(m, 0.0);
  for (int64_t i = 0; i < size(); ++i) {
    const double scale = points_.targets[i] / lambda_[i];
    for (int64_t j = 0; j < m; ++j) weights_[j] += scale * projections_[i * m + j];
  }
  SolveLower(sum_factor_.view(), MatrixView<double>(weights_.data(), m, 1));
  SolveLowerTransposed(sum_factor_.view(), MatrixView<double>(weights_.data(), m, 1));
  return absl::OkStatus();
}

absl::StatusOr<Prediction> SparseModel::Predict(ConstMatrixView<double> points,
                                                PredictWhat what) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  const int64_t m = inducing_size();
  const bool degenerate = options_.approximation == SparseApproximation::kSubsetOfRegressors;
  Prediction prediction;
  for (int64_t begin = 0; begin < points.rows; begin += kPredictionTile) {
    const ConstMatrixView<double> tile =
        points.rows_between(begin, std::min(begin + kPredictionTile, points.rows));
    AlignedMatrix v(tile.rows, m);
    std::vector<double> unused;
    EGOSIEVE_RETURN_IF_ERROR(Project(tile, v, unused));
    std::vector<double> explained;
    for (int64_t i = 0; i < tile.rows; ++i) {
      prediction.mean.push_back(Dot(v.row(i), weights_.data(), m));  // (S4)
      explained.push_back(Square(v.row(i), m));
    }
    if (what == PredictWhat::kMean) continue;
    if (m > 0) AppendRows(sum_factor_.view(), v.view());
    for (int64_t i = 0; i < tile.rows; ++i) {  // (S5)
      const double prior = PriorVariance(hyperparameters_.covariance, tile.row(i));
      const double learnt = Square(v.row(i), m);
      prediction.variance.push_back(
          degenerate && size() > 0 ? learnt : std::max(0.0, prior - explained[i] + learnt));
    }
  }
  return prediction;
}

std::vector<double> SparseModel::PredictOwnMean() const {
  std::vector<double> mean;
  const int64_t m = inducing_size();
  for (int64_t i = 0; i < size(); ++i) {
    mean.push_back(Dot(projections_.data() + i * m, weights_.data(), m));
  }
  return mean;
}

double SparseModel::LogMarginalLikelihood() const {
  double sum = static_cast<double>(size()) * std::log(2.0 * M_PI);
  for (int64_t j = 0; j < inducing_size(); ++j) sum += 2.0 * std::log(sum_factor_.row(j)[j]);
  const std::vector<double> mean = PredictOwnMean();
  for (int64_t i = 0; i < size(); ++i) {
    // y^T Lambda^-1 y - c.A^-1 c = sum_i y_i (y_i - mean_i) / lambda_i.
    sum += std::log(lambda_[i]) + points_.targets[i] * (points_.targets[i] - mean[i]) / lambda_[i];
  }
  return -0.5 * sum;
}

LeaveOneOut SparseModel::PredictLeaveOneOut() const {
  // (Q + Lambda)^-1 = Lambda^-1 - Lambda^-1 V A^-1 V^T Lambda^-1, V's rows being v_i.
  LeaveOneOut result;
  const int64_t n = size(), m = inducing_size();
  const std::vector<double> mean = PredictOwnMean();
  for (int64_t begin = 0; begin < n; begin += kPredictionTile) {
    const int64_t rows = std::min(kPredictionTile, n - begin);
    AlignedMatrix half(rows, m);
    for (int64_t i = 0; i < rows; ++i) {
      std::copy_n(projections_.data() + (begin + i) * m, m, half.row(i));
    }
    AppendRows(sum_factor_.view(), half.view());
    for (int64_t i = 0; i < rows; ++i) {
      const int64_t row = begin + i;
      const double inverse = (1.0 - Square(half.row(i), m) / lambda_[row]) / lambda_[row];
      const double alpha = (points_.targets[row] - mean[row]) / lambda_[row];
      result.rows.push_back(row);
      result.mean.push_back(points_.targets[row] - alpha / inverse);
      result.target_variance.push_back(1.0 / inverse);
    }
  }
  return result;
}

absl::StatusOr<std::shared_ptr<const Posterior>> SparseModel::MakePosterior(
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options) const {
  if (options_.approximation == SparseApproximation::kSubsetOfRegressors) {
    return absl::UnimplementedError(
        "the subset of regressors has no variance on devices; use DTC, whose mean is the same");
  }
  const int64_t m = inducing_size();
  AlignedMatrix inverse(m, m), r(m, m), s(m, m);
  InvertLower(sum_factor_.view(), inverse.view());
  MultiplyInverse(inverse.view(), s.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j <= i; ++j) s.row(i)[j] = (i == j ? 1.0 : 0.0) - s.row(i)[j];
  }
  if (!ReverseFactor(s.view())) {
    return absl::InternalError("I - A^-1 is not positive semidefinite");
  }
  // R = C L^-1, by rows: R L = C, R^T = L^-T C^T.
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) r.row(j)[i] = s.row(i)[j];
  }
  SolveLowerTransposed(factor_.view(), r.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) s.row(i)[j] = j <= i ? r.row(j)[i] : 0.0;
  }
  std::vector<double> alpha(weights_);
  SolveLowerTransposed(factor_.view(), MatrixView<double>(alpha.data(), m, 1));
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inducing_inputs();
  model.alpha = alpha.data();
  model.factor_kind = kernels::FactorKind::kInverseCholesky;
  model.factor = s.view();
  return Posterior::Create(context_, model, hyperparameters_, squash, options);
}

}  // namespace egosieve::gp
