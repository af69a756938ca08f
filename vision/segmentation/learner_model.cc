#include "vision/segmentation/learner_model.h"

#include <limits>

#include "gp/model/regression_model.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::StatusOr<LearnerModel> LearnerModel::Create(std::shared_ptr<kernels::Context> context,
                                                  const gp::Hyperparameters& hyperparameters,
                                                  const LearnerModelOptions& options) {
  LearnerModel model(std::move(context), options);
  EGOSIEVE_RETURN_IF_ERROR(model.Restore({hyperparameters, gp::PointSet()}));
  return model;
}

absl::Status LearnerModel::Restore(const gp::ExactModelState& state) {
  if (options_.kind == ModelKind::kExact) {
    EGOSIEVE_ASSIGN_OR_RETURN(exact_, gp::ExactModel::Restore(context_, state));
    return absl::OkStatus();
  }
  // Solved at once, so that an invalid state is refused here.
  EGOSIEVE_ASSIGN_OR_RETURN(solved_, gp::SparseModel::Restore(context_, state, options_.sparse));
  state_ = state;
  return absl::OkStatus();
}

absl::Status LearnerModel::Add(kernels::ConstMatrixView<float> inputs,
                               absl::Span<const double> labels, int64_t frame) {
  if (inputs.rows == 0 && labels.empty()) return absl::OkStatus();
  const std::vector<double> wide = gp::Widen(inputs);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, gp::TargetsOfLabels(labels));
  const gp::Observations added({wide.data(), inputs.rows, inputs.cols}, targets);
  if (exact_) return exact_->AddObservations(added, frame);
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckAddition(added, state_.points, input_dimension()));
  gp::PointSet points = state_.points;
  points.Append(added, frame);
  state_.points = std::move(points);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status LearnerModel::Remove(absl::Span<const int64_t> rows) {
  if (rows.empty()) return absl::OkStatus();
  if (exact_) return exact_->Remove(rows);
  state_.points.Remove(rows);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status LearnerModel::SetLabels(absl::Span<const double> labels) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, gp::TargetsOfLabels(labels));
  const kernels::ConstMatrixView<double> view(targets.data(), static_cast<int64_t>(targets.size()),
                                              1);
  if (exact_) return exact_->SetTargets(view);
  EGOSIEVE_RETURN_IF_ERROR(gp::ReplaceTargets(view, input_dimension(), state_.points));
  solved_.reset();
  return absl::OkStatus();
}

absl::Status LearnerModel::SetHyperparameters(const gp::Hyperparameters& hyperparameters) {
  if (exact_) return exact_->SetHyperparameters(hyperparameters);
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckReplacement(hyperparameters, size(), input_dimension()));
  state_.hyperparameters = hyperparameters;
  solved_.reset();
  return absl::OkStatus();
}

absl::Status LearnerModel::Rebuild() { return exact_ ? exact_->Refactorize() : absl::OkStatus(); }

absl::StatusOr<const gp::SparseModel*> LearnerModel::Solved() const {
  if (!solved_.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(solved_, gp::SparseModel::Restore(context_, state_, options_.sparse));
  }
  return &*solved_;
}

absl::StatusOr<std::vector<float>> LearnerModel::PredictMean(
    kernels::ConstMatrixView<float> points) const {
  if (exact_) return exact_->PredictMean(points);
  const std::vector<double> wide = gp::Widen(points);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse, Solved());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> mean,
                            sparse->PredictMean({wide.data(), points.rows, points.cols}));
  return std::vector<float>(mean.begin(), mean.end());
}

absl::StatusOr<std::vector<double>> LearnerModel::PredictOwnMean() const {
  if (exact_) return exact_->PredictOwnMean();
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse, Solved());
  return sparse->PredictOwnMean();
}

double LearnerModel::LogMarginalLikelihood() const {
  if (exact_) return exact_->LogMarginalLikelihood();
  const absl::StatusOr<const gp::SparseModel*> sparse = Solved();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return sparse.ok() ? (*sparse)->LogMarginalLikelihood() : kNone;
}

absl::StatusOr<gp::LeaveOneOut> LearnerModel::PredictLeaveOneOut(
    absl::Span<const int64_t> rows) const {
  if (exact_) return exact_->PredictLeaveOneOut(rows);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse, Solved());
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut all, sparse->PredictLeaveOneOut());
  gp::LeaveOneOut chosen;
  for (const int64_t row : rows) {
    chosen.rows.push_back(row);
    chosen.mean.push_back(all.mean[row]);
    chosen.target_variance.push_back(all.target_variance[row]);
  }
  return chosen;
}

absl::StatusOr<std::shared_ptr<const gp::Posterior>> LearnerModel::MakePosterior(
    const gp::SquashParameters& squash) const {
  if (exact_) return exact_->MakePosterior(squash);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse, Solved());
  return sparse->MakePosterior(squash);
}

}  // namespace egosieve::vision
