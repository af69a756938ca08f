#include "gp/model/exact_model.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_format.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/exact_regression.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

RegressionWeights WeightsOf(const IncrementalCholesky& factor,
                            const Hyperparameters& hyperparameters, const PointSet& points) {
  return SolveWeights(factor.Factor(), hyperparameters.mean,
                      points.view(hyperparameters.covariance.input_dimension()),
                      points.target_view());
}

// The lower triangle of K_y for points with this noise.
absl::Status NoisyCovariance(kernels::Context& context, const Hyperparameters& hyperparameters,
                             const Observations& points, double jitter, MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(
      context, hyperparameters.covariance, points.inputs, hyperparameters.noise_variance() + jitter,
      kernels::Triangle::kLower, out));
  for (int64_t i = 0; i < points.size(); ++i) out(i, i) += points.noise_variance(i);
  return absl::OkStatus();
}

// Factor of K_y for points with this noise: the covariances and n^3 / 3 flops run on the device if
// it is suitable.
absl::Status Factorize(kernels::Context& context, const Hyperparameters& hyperparameters,
                       const Observations& points, double jitter, IncrementalCholesky& factor) {
  if (points.size() > 0 && kernels::RegressesOnDevice(context)) {
    return factor.Adopt(points.size(), [&](MatrixView<double> out) {
      return kernels::FactorizeOnDevice(context, hyperparameters.covariance, points.inputs,
                                        hyperparameters.noise_variance() + jitter,
                                        points.noise_variances, out);
    });
  }
  return factor.Factorize(points.size(), [&](MatrixView<double> out) {
    return NoisyCovariance(context, hyperparameters, points, jitter, out);
  });
}

}  // namespace

absl::StatusOr<ExactModel> ExactModel::Restore(std::shared_ptr<kernels::Context> context,
                                               const ExactModelState& state) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(ExactModel model, Create(std::move(context), state.hyperparameters));
  EGOSIEVE_ASSIGN_OR_RETURN(Solution solution,
                            model.Solve(state.hyperparameters, state.points, 0.0, false));
  model.Commit(std::move(solution), state.points);
  return model;
}

absl::StatusOr<ExactModel> ExactModel::Create(std::shared_ptr<kernels::Context> context,
                                              const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  ExactModel model(std::move(context), hyperparameters);
  model.weights_ = WeightsOf(model.factor_, hyperparameters, model.points_);
  return model;
}

absl::Status ExactModel::AddObservations(const Observations& added, int64_t time) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(added, points_, input_dimension()));
  if (added.size() == 0) return absl::OkStatus();

  PointSet points = points_;
  points.Append(added, time);
  const int64_t before = size();
  const bool rebuilds = added.size() >= before && kernels::RegressesOnDevice(*context_);
  const absl::Status status = rebuilds ? absl::OkStatus() : AppendToFactor(added);
  if (rebuilds || IsNotPositiveDefinite(status)) {
    EGOSIEVE_ASSIGN_OR_RETURN(Solution solution,
                              Solve(hyperparameters_, points, jitter_, /*refused=*/!rebuilds));
    Commit(std::move(solution), std::move(points));
    return absl::OkStatus();
  }
  EGOSIEVE_RETURN_IF_ERROR(status);
  absl::Cleanup undo = [&] { factor_.Truncate(before); };
  weights_ = WeightsOf(factor_, hyperparameters_, points);
  points_ = std::move(points);
  std::move(undo).Cancel();
  return absl::OkStatus();
}

absl::Status ExactModel::AppendToFactor(const Observations& added) {
  AlignedMatrix below(added.size(), size());
  AlignedMatrix corner(added.size(), added.size());
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance(*context_, hyperparameters_.covariance,
                                                    added.inputs, inputs(), below.view()));
  EGOSIEVE_RETURN_IF_ERROR(
      NoisyCovariance(*context_, hyperparameters_, added, jitter_, corner.view()));
  return factor_.Append(below.view(), corner.view());
}

absl::StatusOr<ExactModel::Solution> ExactModel::Solve(const Hyperparameters& hyperparameters,
                                                       const PointSet& points, double jitter,
                                                       bool refused) const {
  const Observations observations =
      points.observations(hyperparameters.covariance.input_dimension());
  const double unit = LargestPriorVariance(hyperparameters.covariance, observations.inputs);
  Solution solution{IncrementalCholesky(factor_.capacity()), jitter, {}};
  absl::Status status;
  while (true) {
    if (refused) {
      const std::optional<double> next = NextJitter(solution.jitter, unit);
      if (!next.has_value()) break;
      solution.jitter = *next;
    }
    status = Factorize(*context_, hyperparameters, observations, solution.jitter, solution.factor);
    if (status.ok()) {
      solution.weights = WeightsOf(solution.factor, hyperparameters, points);
      return solution;
    }
    if (!IsNotPositiveDefinite(status)) return status;
    refused = true;
  }
  return NotPositiveDefinite(
      absl::StrFormat("%s; jitter up to %g did not help", status.message(), kLastJitter * unit));
}

void ExactModel::Commit(Solution solution, PointSet points) {
  factor_ = std::move(solution.factor);
  jitter_ = solution.jitter;
  weights_ = std::move(solution.weights);
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
  // The update never refuses a pivot, so it is also the fallback for a failed rebuild. It is in
  // place: once the factor has changed, nothing may fail.
  WeightsMemory memory(hyperparameters_.mean, input_dimension(), left.size(), left.outputs);
  EGOSIEVE_RETURN_IF_ERROR(factor_.Remove(rows));
  weights_ = SolveWeights(factor_.Factor(), left.view(input_dimension()), left.target_view(),
                          std::move(memory));
  points_ = std::move(left);
  return absl::OkStatus();
}

absl::Status ExactModel::SetTargets(ConstMatrixView<double> targets) {
  PointSet points = points_;
  EGOSIEVE_RETURN_IF_ERROR(ReplaceTargets(targets, input_dimension(), points));
  weights_ = WeightsOf(factor_, hyperparameters_, points);
  points_ = std::move(points);
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
  const SharedFactor none{kernels::FactorKind::kNone, {nullptr, size(), size()}, nullptr};
  EGOSIEVE_ASSIGN_OR_RETURN(const auto posterior, Posterior::Create({context_}, hyperparameters_,
                                                                    inputs(), weights_, none, {}));
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

absl::StatusOr<RegressionModel::PosteriorParts> ExactModel::Parts() const {
  const IncrementalCholesky::Kept kept = factor_.Keep();
  return PosteriorParts{
      inputs(), &weights_, {kernels::FactorKind::kCholesky, kept.factor, kept.memory}};
}

absl::StatusOr<std::shared_ptr<const SamplePaths>> ExactModel::DrawPaths(
    const PathOptions& options) const {
  EGOSIEVE_RETURN_IF_ERROR(weights_.CheckDetermined());
  EGOSIEVE_ASSIGN_OR_RETURN(PriorPaths prior,
                            PriorPaths::Draw(hyperparameters_, inputs(), outputs(), options));
  const int64_t n = size(), k = outputs(), columns = prior.columns();
  RegressionWeights update;
  update.outputs = columns;
  std::vector<double> residuals(n * columns);
  prior.AddTo(inputs(), {residuals.data(), n, columns});
  if (n > 0) update = WeightsMemory(hyperparameters_.mean, input_dimension(), n, columns).weights;
  std::vector<double> targets(n * k);
  for (int64_t s = 0; n > 0 && s < options.count; ++s) {  // one by one: its bits are its own
    for (int64_t c = 0; c < k; ++c) {
      const int64_t column = c * options.count + s;
      NormalStream normal = prior.Numbers(column);
      for (int64_t i = 0; i < n; ++i) {
        const double variance =
            hyperparameters_.noise_variance() + points_.noise_variance(i) + jitter_;
        targets[i * k + c] = points_.targets[i * k + c] - residuals[i * columns + column] -
                             std::sqrt(variance) * normal();
      }
    }
    const RegressionWeights own =
        SolveWeights(factor_.Factor(), hyperparameters_.mean, inputs(), {targets.data(), n, k});
    const auto take = [&](const std::vector<double>& from, std::vector<double>& to) {
      for (size_t i = 0; i < from.size(); ++i) {
        to[i / k * columns + i % k * options.count + s] = from[i];
      }
    };
    take(own.alpha, update.alpha);
    take(own.coefficients, update.coefficients);
  }
  return std::make_shared<const SamplePaths>(context_, hyperparameters_, inputs(), std::move(prior),
                                             update, options.of_observation);
}

}  // namespace egosieve::gp
