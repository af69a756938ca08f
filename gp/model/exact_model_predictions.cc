// An ExactModel's predictions; its changes are in exact_model.cc.
#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/container/fixed_array.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/model/exact_model.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/input_gradient.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kPredictionTile = 512;  // points predicted at a time

// (EM3): means (M x k) from k*, one row per point.
void MeansOf(const RegressionWeights& weights, ConstMatrixView<double> points,
             ConstMatrixView<double> k, double* means) {
  kernels::ParallelFor(points.rows, 2.0 * k.rows * k.cols * weights.outputs, [&](int64_t i) {
    double* mean = means + i * weights.outputs;
    WeightedSums(k.row(i), weights.alpha, weights.points, weights.outputs, mean);
    weights.AddMeanFunction(points.cols, points.row(i), mean);
  });
}

// M^-1 r of (W4), one row per point.
AlignedMatrix ReducedBases(const RegressionWeights& weights, ConstMatrixView<double> points,
                           ConstMatrixView<double> k) {
  AlignedMatrix reduced(points.rows, weights.basis);
  if (weights.basis == 0) return reduced;
  kernels::ParallelFor(points.rows, 2.0 * k.rows * k.cols * weights.basis, [&](int64_t i) {
    absl::FixedArray<double, 64> sums(weights.basis);
    WeightedSums(k.row(i), weights.basis_weights, weights.points, weights.basis, sums.data());
    weights.ReducedBasis(points.cols, points.row(i), sums.data(), reduced.row(i));
  });
  return reduced;
}

void Transpose(ConstMatrixView<double> from, MatrixView<double> to) {
  for (int64_t i = 0; i < from.rows; ++i) {
    for (int64_t j = 0; j < from.cols; ++j) to(j, i) = from(i, j);
  }
}

}  // namespace

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

absl::StatusOr<JointPrediction> ExactModel::PredictJoint(ConstMatrixView<double> points) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(weights_.CheckDetermined());
  JointPrediction joint;
  joint.mean.resize(points.rows * outputs());
  joint.covariance = AlignedMatrix(points.rows, points.rows);
  const MatrixView<double> covariance = joint.covariance.view();
  AlignedMatrix cross(points.rows, size());
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(*context_, hyperparameters_.covariance,
                                                            points, inputs(), cross.view()));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix<double>(
      *context_, hyperparameters_.covariance, points, 0.0, kernels::Triangle::kLower, covariance));
  MeansOf(weights_, points, cross.view(), joint.mean.data());
  const AlignedMatrix reduced = ReducedBases(weights_, points, cross.view());
  AppendRows(factor_.Factor(), cross.view());
  AddRowProducts(cross.view(), -1, covariance);  // (EM4)
  AddRowProducts(reduced.view(), 1, covariance);
  for (int64_t i = 0; i < points.rows; ++i) covariance(i, i) = std::max(0.0, covariance(i, i));
  MirrorLower(covariance);
  return joint;
}

absl::StatusOr<NormalSamples> SampleJoint(const Hyperparameters& hyperparameters,
                                          ConstMatrixView<double> points, int64_t outputs,
                                          const SampleOptions& options, JointPrediction& joint) {
  std::vector<double> prior(points.rows);
  for (int64_t i = 0; i < points.rows; ++i) {
    prior[i] = PriorVariance(hyperparameters.covariance, points.row(i));
    if (options.of_observation) joint.covariance.row(i)[i] += hyperparameters.noise_variance();
  }
  return SampleNormal({joint.mean.data(), points.rows, outputs}, joint.covariance.view(), prior,
                      options.count, options.seed);
}

absl::StatusOr<NormalSamples> ExactModel::Sample(ConstMatrixView<double> points,
                                                 const SampleOptions& options) const {
  EGOSIEVE_ASSIGN_OR_RETURN(JointPrediction joint, PredictJoint(points));
  return SampleJoint(hyperparameters_, points, outputs(), options, joint);
}

absl::StatusOr<InputGradients> ExactModel::PredictGradients(ConstMatrixView<double> points,
                                                            PredictWhat what) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(weights_.CheckDetermined());
  const int64_t dimension = input_dimension(), k = outputs(), n = size();
  InputGradients gradients;
  if (points.rows == 0) return gradients;
  gradients.mean.resize(points.rows * k * dimension);
  for (int64_t c = 0; c < k; ++c) {  // (EM5)
    std::vector<double> alpha(n);
    for (int64_t i = 0; i < n; ++i) alpha[i] = weights_.alpha[i * k + c];
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceInputGradient(
        hyperparameters_.covariance, points, inputs(), {alpha.data(), points.rows, n, 0},
        {&gradients.mean[c * dimension], points.rows, dimension, k * dimension}));
    if (weights_.mean != MeanFunction::kLinear) continue;
    for (int64_t i = 0; i < points.rows; ++i) {
      for (int64_t d = 0; d < dimension; ++d) {
        gradients.mean[(i * k + c) * dimension + d] += weights_.coefficients[(d + 1) * k + c];
      }
    }
  }
  if (what == PredictWhat::kMean) return gradients;
  gradients.variance.resize(points.rows * dimension);
  for (int64_t begin = 0; begin < points.rows; begin += kPredictionTile) {
    const int64_t end = std::min(begin + kPredictionTile, points.rows);
    EGOSIEVE_RETURN_IF_ERROR(
        VarianceGradients(points.rows_between(begin, end),
                          {&gradients.variance[begin * dimension], end - begin, dimension}));
  }
  return gradients;
}

absl::Status ExactModel::VarianceGradients(ConstMatrixView<double> points,
                                           MatrixView<double> out) const {
  const int64_t n = size(), q = weights_.basis;
  AlignedMatrix columns(n, points.rows), rows(points.rows, n), u(points.rows, q);
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(*context_, hyperparameters_.covariance,
                                                            inputs(), points, columns.view()));
  Transpose(columns.view(), rows.view());
  for (int64_t i = 0; q > 0 && i < points.rows; ++i) {
    absl::FixedArray<double, 64> sums(q);
    WeightedSums(rows.row(i), weights_.basis_weights, n, q, sums.data());
    weights_.ReducedBasis(points.cols, points.row(i), sums.data(), u.row(i));
    SolveLowerTransposed({weights_.information.data(), q, q}, MatrixView<double>(u.row(i), q, 1));
  }
  SolveLower(factor_.Factor(), columns.view());
  SolveLowerTransposed(factor_.Factor(), columns.view());
  Transpose(columns.view(), rows.view());  // K_y^-1 k*, one row per point
  for (int64_t i = 0; i < points.rows; ++i) {
    for (int64_t j = 0; j < n; ++j) {
      for (int64_t p = 0; p < q; ++p) {
        rows.row(i)[j] += weights_.basis_weights[j * q + p] * u.row(i)[p];
      }
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceInputGradient(hyperparameters_.covariance, points,
                                                            inputs(), rows.view(), out));
  std::vector<double> prior(points.cols);
  for (int64_t i = 0; i < points.rows; ++i) {  // (EM6)
    kernels::PriorVarianceGradient(hyperparameters_.covariance, points.row(i), prior.data());
    for (int64_t d = 0; d < points.cols; ++d) {
      out(i, d) = prior[d] - 2.0 * out(i, d);
      if (weights_.mean == MeanFunction::kLinear) out(i, d) += 2.0 * u.row(i)[d + 1];
    }
  }
  return absl::OkStatus();
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
