#include "gp/model/exact_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_format.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/model/model_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr double kFirstJitter = 1e-10;  // of sigma_f^2
constexpr double kLastJitter = 1e-4;
constexpr int64_t kPredictionTile = 512;  // points predicted at a time

// alpha = (L L^T)^-1 y.
std::vector<double> WeightsOf(const IncrementalCholesky& factor, std::vector<double> targets) {
  const MatrixView<double> column(targets.data(), factor.size(), 1);
  SolveLower(factor.Factor(), column);
  SolveLowerTransposed(factor.Factor(), column);
  return targets;
}

}  // namespace

absl::Status ExactModelState::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  return points.Validate(hyperparameters.covariance.input_dimension());
}

absl::StatusOr<ExactModel> ExactModel::Restore(std::shared_ptr<kernels::Context> context,
                                               const ExactModelState& state) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(ExactModel model, Create(std::move(context), state.hyperparameters));
  EGOSIEVE_ASSIGN_OR_RETURN(Solution solution,
                            model.Solve(state.hyperparameters, state.points, 0.0, false));
  model.Commit(std::move(solution), state.points);
  return model;
}

ExactModelState ExactModel::State() const { return {hyperparameters_, points_}; }

absl::StatusOr<ExactModel> ExactModel::Create(std::shared_ptr<kernels::Context> context,
                                              const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  ExactModel model;
  model.context_ = std::move(context);
  model.hyperparameters_ = hyperparameters;
  return model;
}

absl::Status ExactModel::Add(ConstMatrixView<float> inputs, absl::Span<const double> labels,
                             int64_t frame) {
  const std::vector<double> wide = Widen(inputs);
  return Add(ConstMatrixView<double>(wide.data(), inputs.rows, inputs.cols), labels, frame);
}

absl::Status ExactModel::Add(ConstMatrixView<double> inputs, absl::Span<const double> labels,
                             int64_t frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, TargetsOfLabels(labels));  // (M1)
  return AddTargets(inputs, targets, frame);
}

absl::Status ExactModel::AddTargets(ConstMatrixView<double> inputs,
                                    absl::Span<const double> targets, int64_t frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(inputs, targets, input_dimension()));
  if (inputs.rows == 0) return absl::OkStatus();

  PointSet points = points_;
  points.Append(inputs, targets, frame);
  const int64_t before = size();
  const absl::Status status = AppendToFactor(inputs);
  if (absl::IsFailedPrecondition(status)) {
    EGOSIEVE_ASSIGN_OR_RETURN(Solution solution, Solve(hyperparameters_, points, jitter_, true));
    Commit(std::move(solution), std::move(points));
    return absl::OkStatus();
  }
  EGOSIEVE_RETURN_IF_ERROR(status);
  absl::Cleanup undo = [&] { factor_.Truncate(before); };
  alpha_ = WeightsOf(factor_, points.targets);
  points_ = std::move(points);
  std::move(undo).Cancel();
  return absl::OkStatus();
}

absl::Status ExactModel::AppendToFactor(ConstMatrixView<double> points) {
  const kernels::CovarianceParameters& covariance = hyperparameters_.covariance;
  AlignedMatrix below(points.rows, size());
  AlignedMatrix corner(points.rows, points.rows);
  EGOSIEVE_RETURN_IF_ERROR(
      kernels::CrossCovariance<double>(*context_, covariance, points, inputs(), below.view()));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix<double>(
      *context_, covariance, points, hyperparameters_.noise_variance() + jitter_,
      kernels::Triangle::kLower, corner.view()));
  return factor_.Append(below.view(), corner.view());
}

absl::StatusOr<ExactModel::Solution> ExactModel::Solve(const Hyperparameters& hyperparameters,
                                                       const PointSet& points, double jitter,
                                                       bool refused) const {
  const ConstMatrixView<double> x = points.view(hyperparameters.covariance.input_dimension());
  const double signal_stddev = hyperparameters.covariance.signal_stddev;
  const double unit = signal_stddev * signal_stddev;
  IncrementalCholeskyOptions options;
  options.least_capacity = factor_.capacity();
  Solution solution{IncrementalCholesky(options), jitter, {}};
  absl::Status status;
  while (true) {
    if (refused) {
      if (!(solution.jitter < kLastJitter * unit)) break;
      solution.jitter = std::max(10.0 * solution.jitter, kFirstJitter * unit);
    }
    status = solution.factor.Factorize(x.rows, [&](MatrixView<double> out) {
      return kernels::CovarianceMatrix<double>(*context_, hyperparameters.covariance, x,
                                               hyperparameters.noise_variance() + solution.jitter,
                                               kernels::Triangle::kLower, out);
    });
    if (status.ok()) {
      solution.alpha = WeightsOf(solution.factor, points.targets);
      return solution;
    }
    if (!absl::IsFailedPrecondition(status)) return status;
    refused = true;
  }
  return absl::FailedPreconditionError(
      absl::StrFormat("%s; jitter up to %g did not help", status.message(), kLastJitter * unit));
}

void ExactModel::Commit(Solution solution, PointSet points) {
  factor_ = std::move(solution.factor);
  jitter_ = solution.jitter;
  alpha_ = std::move(solution.alpha);
  points_ = std::move(points);
}

absl::Status ExactModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  PointSet left = points_;
  left.Remove(rows);
  if (factor_.RefactoringIsCheaper(rows)) {
    absl::StatusOr<Solution> solution = Solve(hyperparameters_, left, jitter_, false);
    if (solution.ok()) {
      Commit(*std::move(solution), std::move(left));
      return absl::OkStatus();
    }
  }
  // The update finds no pivot to refuse, so it also serves where a rebuild does.
  EGOSIEVE_RETURN_IF_ERROR(factor_.Remove(rows));
  points_ = std::move(left);
  alpha_ = WeightsOf(factor_, points_.targets);
  return absl::OkStatus();
}

absl::Status ExactModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  Hyperparameters copy = hyperparameters;
  EGOSIEVE_ASSIGN_OR_RETURN(Solution solution, Solve(hyperparameters, points_, 0.0, false));
  Commit(std::move(solution), std::move(points_));
  hyperparameters_ = std::move(copy);
  return absl::OkStatus();
}

absl::Status ExactModel::Refactorize() {
  return SetHyperparameters(Hyperparameters(hyperparameters_));
}

absl::StatusOr<std::vector<float>> ExactModel::PredictMean(ConstMatrixView<float> points) const {
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inputs();
  model.alpha = alpha_.data();
  EGOSIEVE_ASSIGN_OR_RETURN(const auto dense, kernels::DensePosterior::Create(context_, model));
  std::vector<float> mean(points.rows);
  kernels::PosteriorOutputs outputs;
  outputs.mean = mean.data();
  EGOSIEVE_RETURN_IF_ERROR(dense->Evaluate(points, outputs).status());
  return mean;
}

std::vector<double> ExactModel::PredictOwnMean() const {
  // K alpha = (L L^T) alpha - (sigma_n^2 + jitter) alpha = y - (sigma_n^2 + jitter) alpha.
  const double diagonal = hyperparameters_.noise_variance() + jitter_;
  std::vector<double> mean(points_.targets);
  for (size_t i = 0; i < mean.size(); ++i) mean[i] -= diagonal * alpha_[i];
  return mean;
}

absl::StatusOr<Prediction> ExactModel::Predict(ConstMatrixView<double> points,
                                               PredictWhat what) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  Prediction prediction;
  prediction.mean.resize(points.rows);
  if (what == PredictWhat::kMeanAndVariance) prediction.variance.resize(points.rows);
  const int64_t n = size();
  AlignedMatrix cross(std::min(kPredictionTile, points.rows), n);
  for (int64_t begin = 0; begin < points.rows; begin += kPredictionTile) {
    const int64_t end = std::min(begin + kPredictionTile, points.rows);
    const MatrixView<double> k = cross.block(end - begin, n);
    EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(
        *context_, hyperparameters_.covariance, points.rows_between(begin, end), inputs(), k));
    for (int64_t i = begin; i < end; ++i) {
      const double* row = k.row(i - begin);
      double sum = 0.0;
      for (int64_t j = 0; j < n; ++j) sum += row[j] * alpha_[j];
      prediction.mean[i] = sum;
    }
    if (what == PredictWhat::kMean) continue;
    AppendRows(factor_.Factor(), k);
    for (int64_t i = begin; i < end; ++i) {
      const double* row = k.row(i - begin);
      double explained = 0.0;
      for (int64_t j = 0; j < n; ++j) explained += row[j] * row[j];
      const double left = PriorVariance(hyperparameters_.covariance, points.row(i)) - explained;
      prediction.clamped_variances += left < 0.0;
      prediction.variance[i] = std::max(0.0, left);
    }
  }
  return prediction;
}

double ExactModel::LogMarginalLikelihood() const {
  double fit = 0.0;
  for (size_t i = 0; i < alpha_.size(); ++i) fit += targets()[i] * alpha_[i];
  return -0.5 *
         (fit + factor_.LogDeterminant() + static_cast<double>(size()) * std::log(2.0 * M_PI));
}

absl::StatusOr<LeaveOneOut> ExactModel::PredictLeaveOneOut(absl::Span<const int64_t> rows) const {
  return ComputeLeaveOneOut(factor_, points_.targets, alpha_, rows);
}

absl::StatusOr<std::shared_ptr<const Posterior>> ExactModel::MakePosterior(
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options) const {
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inputs();
  model.alpha = alpha_.data();
  model.factor_kind = kernels::FactorKind::kCholesky;
  model.factor = factor_.Factor();
  return Posterior::Create(context_, model, hyperparameters_, squash, options);
}

}  // namespace egosieve::gp
