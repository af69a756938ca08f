// The learner's Gaussian process, exact or with inducing inputs, behind one interface.
//
//   kExact    gp/model/exact_model.h     n^2 per query: the paper's
//   kSparse   gp/model/sparse_model.h    m^2 per query: every pixel is affordable
//
// The sparse model is solved at the first query after a change, and the solution is kept until the
// next change: an online learner changes about half of its points per frame, and then the
// hyperparameters. One solution, n m^2, costs less than adding and removing terms and solving after
// each change. Answers depend on points and hyperparameters alone, not on their history.
//
// Every change, Rebuild included, is a deterministic function of the model and its arguments: two
// models that agree to the last bit still agree after the same changes.
//
// Not thread-safe, queries included; a posterior is thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/exact_model.h"
#include "gp/model/point_set.h"
#include "gp/model/posterior.h"
#include "gp/model/sparse_model.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::vision {

enum class ModelKind { kExact, kSparse };

struct LearnerModelOptions {
  ModelKind kind = ModelKind::kExact;
  gp::SparseModelOptions sparse;  // for kSparse; DTC or FITC; refresh_share has no effect
};

class LearnerModel {
 public:
  static absl::StatusOr<LearnerModel> Create(std::shared_ptr<kernels::Context> context,
                                             const gp::Hyperparameters& hyperparameters,
                                             const LearnerModelOptions& options);

  // As ExactModel's. After an error the model is unchanged.
  absl::Status Add(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                   int64_t frame);
  absl::Status Remove(absl::Span<const int64_t> rows);
  // Labels of all points, in their order; in [0, 1].
  absl::Status SetLabels(absl::Span<const double> labels);
  absl::Status SetHyperparameters(const gp::Hyperparameters& hyperparameters);

  // Afterwards results depend on points and hyperparameters alone, not on the history.
  absl::Status Rebuild();
  gp::ExactModelState State() const { return exact_ ? exact_->State() : state_; }
  // Gives the model that `state` was taken from, as it is after Rebuild.
  absl::Status Restore(const gp::ExactModelState& state);

  int64_t size() const { return points().size(); }
  int64_t input_dimension() const { return hyperparameters().covariance.input_dimension(); }
  const gp::Hyperparameters& hyperparameters() const {
    return exact_ ? exact_->hyperparameters() : state_.hyperparameters;
  }
  const std::shared_ptr<kernels::Context>& context() const { return context_; }
  double jitter() const { return exact_ ? exact_->jitter() : 0.0; }

  // Views are valid until the next change.
  const gp::PointSet& points() const { return exact_ ? exact_->points() : state_.points; }
  kernels::ConstMatrixView<double> inputs() const { return points().view(input_dimension()); }
  absl::Span<const double> targets() const { return points().targets; }
  absl::Span<const int64_t> birth_frames() const { return points().insertion_times; }

  absl::StatusOr<std::vector<float>> PredictMean(kernels::ConstMatrixView<float> points) const;
  absl::StatusOr<std::vector<double>> PredictOwnMean() const;
  double LogMarginalLikelihood() const;  // NaN if a sparse model cannot be solved
  // For these rows.
  absl::StatusOr<gp::LeaveOneOut> PredictLeaveOneOut(absl::Span<const int64_t> rows) const;
  absl::StatusOr<std::shared_ptr<const gp::Posterior>> MakePosterior(
      const gp::SquashParameters& squash) const;

 private:
  LearnerModel(std::shared_ptr<kernels::Context> context, const LearnerModelOptions& options)
      : context_(std::move(context)), options_(options) {}

  // The sparse model; valid until the next change. The errors are those of SparseModel::Refresh.
  absl::StatusOr<const gp::SparseModel*> Solved() const;

  std::shared_ptr<kernels::Context> context_;
  LearnerModelOptions options_;
  std::optional<gp::ExactModel> exact_;  // where the model is exact; the next two are
  gp::ExactModelState state_;            // those of a sparse one
  mutable std::optional<gp::SparseModel> solved_;
};

}  // namespace egosieve::vision
