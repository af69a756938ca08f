// An ExactModel's predictions; its changes are in exact_model.cc.
#include <cmath>
#include <vector>

#include "gp/linalg/cholesky.h"
#include "gp/model/exact_model.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {

using kernels::ConstMatrixView;

absl::StatusOr<std::vector<float>> ExactModel::PredictMean(ConstMatrixView<float> points) const {
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inputs();
  EGOSIEVE_ASSIGN_OR_RETURN(
      const auto posterior,
      Posterior::Create({context_}, model, hyperparameters_, SquashParameters{}, weights_));
  std::vector<float> mean(points.rows * outputs());
  kernels::PosteriorOutputs wanted;
  wanted.mean = mean.data();
  EGOSIEVE_RETURN_IF_ERROR(posterior->Evaluate(points, wanted).status());
  return mean;
}

std::vector<double> ExactModel::PredictOwnMean() const {
  // K alpha + H B = Y - (K_y - K) alpha.
  std::vector<double> mean(points_.targets);
  if (!weights_.determined) return mean;
  const int64_t k = outputs();
  for (int64_t i = 0; i < size(); ++i) {
    const double diagonal = hyperparameters_.noise_variance() + jitter_ + points_.noise_variance(i);
    for (int64_t c = 0; c < k; ++c) mean[i * k + c] -= diagonal * weights_.alpha[i * k + c];
  }
  return mean;
}

absl::StatusOr<Prediction> ExactModel::Predict(ConstMatrixView<double> points,
                                               PredictWhat what) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const Float64Posterior> posterior,
                            MakeFloat64Posterior());
  Prediction prediction;
  prediction.mean.resize(points.rows * outputs());
  if (what == PredictWhat::kMeanAndVariance) prediction.variance.resize(points.rows);
  EGOSIEVE_ASSIGN_OR_RETURN(
      prediction.clamped_variances,
      posterior->Evaluate(points, prediction.mean.data(),
                          what == PredictWhat::kMean ? nullptr : prediction.variance.data()));
  return prediction;
}

double ExactModel::LogMarginalLikelihood() const {
  if (!weights_.determined && size() > 0) return std::nan("");
  double fit = 0.0;
  for (size_t i = 0; i < weights_.alpha.size(); ++i) fit += targets()[i] * weights_.alpha[i];
  if (size() == 0) return 0.0;
  const double each = factor_.LogDeterminant() + 2.0 * weights_.HalfLogDeterminant() +
                      static_cast<double>(size() - weights_.basis) * std::log(2.0 * M_PI);
  return -0.5 * (fit + static_cast<double>(outputs()) * each);
}

absl::StatusOr<LeaveOneOut> ExactModel::PredictLeaveOneOut(absl::Span<const int64_t> rows) const {
  EGOSIEVE_RETURN_IF_ERROR(weights_.CheckDetermined());
  const int64_t q = weights_.basis;
  const std::vector<double> reduced = weights_.ReducedRows();
  std::vector<double> shares(q > 0 ? size() : 0);
  for (size_t i = 0; i < shares.size(); ++i) shares[i] = Square(&reduced[i * q], q);
  EGOSIEVE_ASSIGN_OR_RETURN(LeaveOneOut left_out, ComputeLeaveOneOut(factor_, points_.targets,
                                                                     weights_.alpha, rows, shares));
  if (!points_.noise_variances.empty()) {
    for (const int64_t row : left_out.rows) {
      left_out.noise_variances.push_back(points_.noise_variances[row]);
    }
  }
  return left_out;
}

absl::StatusOr<std::shared_ptr<const Float64Posterior>> ExactModel::MakeFloat64Posterior() const {
  EGOSIEVE_RETURN_IF_ERROR(weights_.CheckDetermined());
  const IncrementalCholesky::Kept kept = factor_.Keep();
  return std::make_shared<const Float64Posterior>(
      context_, hyperparameters_, inputs(), weights_,
      SharedFactor{kernels::FactorKind::kCholesky, kept.factor, kept.memory});
}

absl::StatusOr<std::shared_ptr<const Posterior>> ExactModel::MakePosterior(
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options,
    const kernels::Contexts& devices) const {
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inputs();
  model.factor_kind = kernels::FactorKind::kCholesky;
  model.factor = factor_.Factor();
  return Posterior::Create(devices.empty() ? kernels::Contexts{context_} : devices, model,
                           hyperparameters_, squash, weights_, options);
}

}  // namespace egosieve::gp
