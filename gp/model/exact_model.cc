#include "gp/model/exact_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

}  // namespace

absl::Status ExactModelState::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  return points.Validate(hyperparameters.covariance.input_dimension());
}

absl::StatusOr<ExactModel> ExactModel::Restore(std::shared_ptr<kernels::Context> context,
                                               const ExactModelState& state) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(ExactModel model, Create(std::move(context), state.hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(model.Rebuild(state.hyperparameters, state.points.inputs, 0.0, false));
  model.points_ = state.points;
  model.UpdateAlpha();
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

  absl::Status status = AppendToFactor(inputs);
  if (absl::IsFailedPrecondition(status)) {
    std::vector<double> all(points_.inputs);
    for (int64_t i = 0; i < inputs.rows; ++i) {
      all.insert(all.end(), inputs.row(i), inputs.row(i) + inputs.cols);
    }
    status = Rebuild(hyperparameters_, all, jitter_, true);
  }
  EGOSIEVE_RETURN_IF_ERROR(status);
  points_.Append(inputs, targets, frame);
  UpdateAlpha();
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

absl::Status ExactModel::Rebuild(const Hyperparameters& hyperparameters,
                                 const std::vector<double>& points, double jitter, bool refused) {
  const int64_t dimension = hyperparameters.covariance.input_dimension();
  const ConstMatrixView<double> x(points.data(), static_cast<int64_t>(points.size()) / dimension,
                                  dimension);
  const double signal_stddev = hyperparameters.covariance.signal_stddev;
  const double unit = signal_stddev * signal_stddev;
  absl::Status status;
  while (true) {
    if (refused) {
      if (!(jitter < kLastJitter * unit)) break;
      jitter = std::max(10.0 * jitter, kFirstJitter * unit);
    }
    status = factor_.Factorize(x.rows, [&](MatrixView<double> out) {
      return kernels::CovarianceMatrix<double>(*context_, hyperparameters.covariance, x,
                                               hyperparameters.noise_variance() + jitter,
                                               kernels::Triangle::kLower, out);
    });
    if (status.ok()) jitter_ = jitter;
    if (!absl::IsFailedPrecondition(status)) return status;
    refused = true;
  }
  return absl::FailedPreconditionError(
      absl::StrFormat("%s; jitter up to %g did not help", status.message(), kLastJitter * unit));
}

absl::Status ExactModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  PointSet left = points_;
  left.Remove(rows);
  // The update cannot fail, so it also serves where a rebuild does.
  if (!factor_.RefactoringIsCheaper(rows) ||
      !Rebuild(hyperparameters_, left.inputs, jitter_, false).ok()) {
    EGOSIEVE_RETURN_IF_ERROR(factor_.Remove(rows));
  }
  points_ = std::move(left);
  UpdateAlpha();
  return absl::OkStatus();
}

absl::Status ExactModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(Rebuild(hyperparameters, points_.inputs, 0.0, false));
  hyperparameters_ = hyperparameters;
  UpdateAlpha();
  return absl::OkStatus();
}

absl::Status ExactModel::Refactorize() {
  return SetHyperparameters(Hyperparameters(hyperparameters_));
}

void ExactModel::UpdateAlpha() {
  alpha_ = points_.targets;
  const MatrixView<double> column(alpha_.data(), size(), 1);
  SolveLower(factor_.Factor(), column);
  SolveLowerTransposed(factor_.Factor(), column);
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
      prediction.variance[i] =
          std::max(0.0, PriorVariance(hyperparameters_.covariance, points.row(i)) - explained);
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
