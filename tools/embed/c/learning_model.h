// The object behind an egosieve_gp: an exact or a sparse model, its calibration, the posterior made
// from both, and a lock.
//
// Changes wait for each other. Posterior() waits for a change in progress, and makes the posterior
// if the model has changed since the last call. Evaluating a posterior needs no lock.
#ifndef EGOSIEVE_TOOLS_EMBED_C_LEARNING_MODEL_H_
#define EGOSIEVE_TOOLS_EMBED_C_LEARNING_MODEL_H_

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/io/model_file.h"
#include "gp/model/adaptive_posterior.h"
#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/laplace_approximation.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"
#include "tools/embed/c/hyperparameter_search.h"
#include "tools/embed/c/prediction.h"

namespace egosieve::embed {

// Leave-one-out predictions of all points, of either kind of model.
template <typename Model>
absl::StatusOr<gp::LeaveOneOut> LeaveOneOutOf(const Model& model) {
  return model.PredictLeaveOneOut();
}

class LearningModel {
 public:
  // sparse: options of a sparse model; without them the model is exact.
  static absl::StatusOr<std::shared_ptr<LearningModel>> Create(
      std::shared_ptr<kernels::Context> context, const gp::Hyperparameters& hyperparameters,
      const std::optional<gp::SparseModelOptions>& sparse,
      const kernels::DensePosteriorOptions& options);
  static absl::StatusOr<std::shared_ptr<LearningModel>> FromFile(
      std::shared_ptr<kernels::Context> context, gp::ModelFile file);

  // State of a model at one moment.
  struct Description {
    gp::Hyperparameters hyperparameters;
    gp::SquashParameters squash;
    int64_t size = 0;
    double jitter = 0.0;
    bool has_labels = false;
    int64_t outputs = 1;
    std::optional<gp::SparseModelOptions> sparse;
    int64_t inducing_size = 0;  // current m
  };

  absl::Status Condition(const gp::Observations& added);
  // rows: each once, in any order.
  absl::Status Remove(std::vector<int64_t> rows);
  absl::Status SetHyperparameters(const std::vector<double>& scales, double signal_stddev,
                                  double noise_stddev);
  absl::StatusOr<SearchResult> Optimize(const SearchOptions& options);
  // Replaces the points by the regression that stands for Laplace's approximation
  // (gp/training/laplace_approximation.h); sigma_n becomes 1e-3. search: null to keep the other
  // hyperparameters. The likelihoods of the result are those of the labels.
  absl::StatusOr<SearchResult> Classify(const gp::LabelledInputs& data,
                                        const SearchOptions* search);
  // Does nothing if the model has not changed since the last call.
  absl::Status Calibrate();
  void SetAnnotation(std::string annotation);
  // Rebuilds the factor, or chooses the inducing inputs again.
  absl::StatusOr<gp::ModelFile> ToFile();

  int64_t dimension() const { return dimension_; }  // D, never changes
  const std::shared_ptr<kernels::Context>& context() const { return context_; }
  Description Describe() const;
  // Calls `ask` with the model, a gp::ExactModel or gp::SparseModel, under the lock; returns its
  // result.
  template <typename Ask>
  auto With(Ask&& ask) const {
    std::lock_guard lock(mutex_);
    return std::visit(std::forward<Ask>(ask), model_);
  }
  std::string annotation() const;
  absl::StatusOr<DevicePosterior> Posterior();
  // The same on these devices, which share its queries; made by each call.
  absl::StatusOr<DevicePosterior> PosteriorOn(const kernels::Contexts& devices) const;

 private:
  using Model = std::variant<gp::ExactModel, gp::SparseModel>;

  LearningModel(Model model, const kernels::DensePosteriorOptions& options);
  // Called under the lock: discards everything derived from the model.
  void Changed();

  const std::shared_ptr<kernels::Context> context_;
  const int64_t dimension_;
  const kernels::DensePosteriorOptions options_;
  mutable std::mutex mutex_;  // guards all members below
  Model model_;
  gp::SquashParameters squash_;
  bool calibrated_ = false;  // squash_ fits the current model
  bool is_laplace_ = false;  // the points are those of Classify
  bool is_renewed_ = false;  // the factor is what ToFile would rebuild
  std::string annotation_;
  std::shared_ptr<const gp::AdaptivePosterior> posterior_;  // null: not made yet
};

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_LEARNING_MODEL_H_
