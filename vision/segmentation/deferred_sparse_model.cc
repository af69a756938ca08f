#include "vision/segmentation/deferred_sparse_model.h"

#include <utility>

#include "gp/model/model_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::StatusOr<DeferredSparseModel> DeferredSparseModel::Restore(
    std::shared_ptr<kernels::Context> context, gp::ExactModelState state,
    const gp::SparseModelOptions& options) {
  DeferredSparseModel model;
  // Solved at once, so that an invalid state is refused here.
  EGOSIEVE_ASSIGN_OR_RETURN(model.solved_, gp::SparseModel::Restore(context, state, options));
  model.context_ = std::move(context);
  model.options_ = options;
  model.state_ = std::move(state);
  return model;
}

absl::Status DeferredSparseModel::AddObservations(const gp::Observations& added, int64_t frame) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckAddition(added, state_.points, input_dimension()));
  gp::PointSet points = state_.points;
  points.Append(added, frame);
  state_.points = std::move(points);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckRows(rows, size()));
  state_.points.Remove(rows);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::SetTargets(kernels::ConstMatrixView<double> targets) {
  EGOSIEVE_RETURN_IF_ERROR(gp::ReplaceTargets(targets, input_dimension(), state_.points));
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::SetHyperparameters(const gp::Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckReplacement(hyperparameters, size(), input_dimension()));
  state_.hyperparameters = hyperparameters;
  solved_.reset();
  return absl::OkStatus();
}

absl::StatusOr<const gp::SparseModel*> DeferredSparseModel::Solved() const {
  if (!solved_.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(solved_, gp::SparseModel::Restore(context_, state_, options_));
  }
  return &*solved_;
}

}  // namespace egosieve::vision
