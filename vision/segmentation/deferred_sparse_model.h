// Points and hyperparameters of a sparse model (gp/model/sparse_model.h). The model is solved at
// the first query after a change, and the solution is kept until the next change.
//
// An online learner changes about half of its points per frame, and then the hyperparameters. One
// solution, n m^2, costs less than adding and removing terms and solving after each change. Answers
// depend on points and hyperparameters alone, not on their history.
//
// Not thread-safe, queries included; a posterior is thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/exact_model.h"
#include "gp/model/point_set.h"
#include "gp/model/sparse_model.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::vision {

class DeferredSparseModel {
 public:
  // InvalidArgument for a state or options that SparseModel::Restore refuses.
  static absl::StatusOr<DeferredSparseModel> Restore(std::shared_ptr<kernels::Context> context,
                                                     gp::ExactModelState state,
                                                     const gp::SparseModelOptions& options);

  // Checked like SparseModel's. After an error nothing has changed.
  absl::Status AddObservations(const gp::Observations& added, int64_t frame);
  absl::Status Remove(absl::Span<const int64_t> rows);
  absl::Status SetTargets(kernels::ConstMatrixView<double> targets);
  absl::Status SetHyperparameters(const gp::Hyperparameters& hyperparameters);

  const gp::ExactModelState& State() const { return state_; }
  int64_t size() const { return state_.points.size(); }
  int64_t input_dimension() const { return hyperparameters().covariance.input_dimension(); }
  const gp::Hyperparameters& hyperparameters() const { return state_.hyperparameters; }

  // Valid until the next change. The errors are those of SparseModel::Refresh.
  absl::StatusOr<const gp::SparseModel*> Solved() const;

 private:
  DeferredSparseModel() = default;

  std::shared_ptr<kernels::Context> context_;
  gp::SparseModelOptions options_;
  gp::ExactModelState state_;
  mutable std::optional<gp::SparseModel> solved_;
};

}  // namespace egosieve::vision
