// A SparseModel's predictions; its changes are in sparse_model.cc.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gp/covariance/prior_variance.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/model/sparse_model.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

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

}  // namespace

absl::StatusOr<Prediction> SparseModel::Predict(ConstMatrixView<double> points,
                                                PredictWhat what) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, input_dimension()));
  const int64_t m = inducing_size();
  const bool degenerate = IsDegenerate();
  Prediction prediction;
  for (int64_t begin = 0; begin < points.rows; begin += kPredictionTile) {
    const ConstMatrixView<double> tile =
        points.rows_between(begin, std::min(begin + kPredictionTile, points.rows));
    AlignedMatrix v(tile.rows, m);
    std::vector<double> unused;
    EGOSIEVE_RETURN_IF_ERROR(
        ProjectPoints(*context_, options_, hyperparameters_, solution_, tile, {}, v, unused));
    std::vector<double> explained;
    for (int64_t i = 0; i < tile.rows; ++i) {
      prediction.mean.push_back(Dot(v.row(i), solution_.weights.data(), m));  // (SP4)
      explained.push_back(Square(v.row(i), m));
    }
    if (what == PredictWhat::kMean) continue;
    if (m > 0) AppendRows(solution_.sum_factor.view(), v.view());
    for (int64_t i = 0; i < tile.rows; ++i) {  // (SP5)
      const double prior = PriorVariance(hyperparameters_.covariance, tile.row(i));
      const double learnt = Square(v.row(i), m);
      const double variance = degenerate ? learnt : prior - explained[i] + learnt;
      prediction.clamped_variances += variance < 0.0;
      prediction.variance.push_back(std::max(0.0, variance));
    }
  }
  return prediction;
}

std::vector<double> SparseModel::MeanCoefficients() const {
  std::vector<double> alpha(solution_.weights);
  SolveLowerTransposed(solution_.factor.view(),
                       MatrixView<double>(alpha.data(), inducing_size(), 1));
  return alpha;
}

std::vector<double> SparseModel::PredictOwnMean() const {
  std::vector<double> mean;
  const int64_t m = inducing_size();
  for (int64_t i = 0; i < size(); ++i) {
    mean.push_back(Dot(solution_.projections.data() + i * m, solution_.weights.data(), m));
  }
  return mean;
}

double SparseModel::LogMarginalLikelihood() const {
  double sum = static_cast<double>(size()) * std::log(2.0 * M_PI);
  for (int64_t j = 0; j < inducing_size(); ++j)
    sum += 2.0 * std::log(solution_.sum_factor.row(j)[j]);
  const std::vector<double> mean = PredictOwnMean();
  for (int64_t i = 0; i < size(); ++i) {
    // y^T Lambda^-1 y - c.A^-1 c = sum_i y_i (y_i - mean_i) / lambda_i.
    sum += std::log(solution_.lambda[i]) +
           points_.targets[i] * (points_.targets[i] - mean[i]) / solution_.lambda[i];
  }
  return -0.5 * sum;
}

LeaveOneOut SparseModel::PredictLeaveOneOut() const {
  // (Q + Lambda)^-1 = Lambda^-1 - Lambda^-1 V A^-1 V^T Lambda^-1; the rows of V are v_i.
  LeaveOneOut result;
  result.noise_variances = points_.noise_variances;
  const int64_t n = size(), m = inducing_size();
  const std::vector<double> mean = PredictOwnMean();
  for (int64_t begin = 0; begin < n; begin += kPredictionTile) {
    const int64_t rows = std::min(kPredictionTile, n - begin);
    AlignedMatrix half(rows, m);
    for (int64_t i = 0; i < rows; ++i) {
      std::copy_n(solution_.projections.data() + (begin + i) * m, m, half.row(i));
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

absl::StatusOr<std::shared_ptr<const SparsePosteriorForm>> SparseModel::PosteriorForm() const {
  if (options_.approximation == SparseApproximation::kSubsetOfRegressors) {
    return absl::UnimplementedError(
        "the subset of regressors has no variance on devices; use DTC, whose mean is the same");
  }
  if (solution_.posterior_form != nullptr) return solution_.posterior_form;
  const int64_t m = inducing_size();
  AlignedMatrix inverse(m, m), r(m, m), s(m, m);
  InvertLower(solution_.sum_factor.view(), inverse.view());
  MultiplyInverse(inverse.view(), s.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j <= i; ++j) s.row(i)[j] = (i == j ? 1.0 : 0.0) - s.row(i)[j];
  }
  if (!ReverseFactor(s.view())) {
    return absl::FailedPreconditionError(
        "I - A^-1 is not positive semidefinite to working precision; take a larger noise");
  }
  // R = C L^-1, by rows: R L = C, R^T = L^-T C^T.
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) r.row(j)[i] = s.row(i)[j];
  }
  SolveLowerTransposed(solution_.factor.view(), r.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) s.row(i)[j] = j <= i ? r.row(j)[i] : 0.0;
  }
  solution_.posterior_form = std::make_shared<const SparsePosteriorForm>(
      SparsePosteriorForm{std::move(s), MeanCoefficients()});
  return solution_.posterior_form;
}

absl::StatusOr<std::shared_ptr<const Posterior>> SparseModel::MakePosterior(
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options,
    const kernels::Contexts& devices) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const SparsePosteriorForm> form, PosteriorForm());
  kernels::PosteriorModel model;
  model.covariance = hyperparameters_.covariance;
  model.inputs = inducing_inputs();
  model.alpha = form->alpha.data();
  model.factor_kind = kernels::FactorKind::kInverseCholesky;
  model.factor = form->root.view();
  return Posterior::Create(devices.empty() ? kernels::Contexts{context_} : devices, model,
                           hyperparameters_, squash, options);
}

absl::StatusOr<std::shared_ptr<const Float64Posterior>> SparseModel::MakeFloat64Posterior() const {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const SparsePosteriorForm> form, PosteriorForm());
  RegressionWeights weights;
  weights.points = inducing_size();
  weights.alpha = form->alpha;
  return std::make_shared<const Float64Posterior>(
      context_, hyperparameters_, inducing_inputs(), weights,
      SharedFactor{kernels::FactorKind::kInverseCholesky, form->root.view(), form});
}

}  // namespace egosieve::gp
