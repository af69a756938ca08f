// The objects behind an egosieve_gp and an egosieve_posterior.
//
// A LearningModel is an exact, a sparse or an iterative model, its calibration, the posterior made
// from both, and a lock. Changes wait for each other. Posterior() waits for a change in progress,
// and makes the posterior if the model has changed since the last call. Evaluating a posterior
// needs no lock.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/io/model_file.h"
#include "gp/model/adaptive_posterior.h"
#include "gp/model/exact_model.h"
#include "gp/model/iterative_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/laplace_approximation.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"
#include "tools/embed/c/handle_table.h"
#include "tools/embed/c/hyperparameter_search.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

// A posterior with its device, or the first of its devices.
struct DevicePosterior {
  std::shared_ptr<kernels::Context> context;
  std::shared_ptr<const gp::AdaptivePosterior> posterior;
  absl::Status labels;  // if the targets are no labels: why there are no probabilities
  int64_t devices = 1;

  const gp::Posterior& in_float32() const { return posterior->in_float32(); }
  int64_t outputs() const { return in_float32().outputs(); }
  int64_t dimension() const { return in_float32().hyperparameters().covariance.input_dimension(); }
};

// Errors are thrown.
class LearningModel {
 public:
  // From what a file holds; also a model without points.
  static std::shared_ptr<LearningModel> Create(std::shared_ptr<kernels::Context> context,
                                               gp::ModelFile file,
                                               const kernels::DensePosteriorOptions& options = {});

  void Condition(const gp::Observations& added);
  // rows: each once, in any order.
  void Remove(std::vector<int64_t> rows);
  void SetHyperparameters(std::vector<double> scales, double signal_stddev, double noise_stddev);
  SearchResult Optimize(const egosieve_optimize_options& options);
  // Replaces the points by the regression that stands for Laplace's approximation
  // (gp/training/laplace_approximation.h); sigma_n becomes 1e-3. search: null to keep the other
  // hyperparameters. The likelihoods of the result are those of the labels.
  SearchResult Classify(const gp::LabelledInputs& data, const egosieve_optimize_options* search);
  // Does nothing if the model has not changed since the last call.
  void Calibrate();
  void SetAnnotation(std::string annotation);
  // Rebuilds the factor, chooses the inducing inputs again, or makes the weights where they are not
  // there.
  gp::ModelFile ToFile();

  int64_t dimension() const { return dimension_; }  // D, never changes
  const std::shared_ptr<kernels::Context>& context() const { return context_; }
  // Calls `ask` with the gp::ExactModel, gp::SparseModel or gp::IterativeModel, under the lock.
  template <typename Ask>
  auto Visit(Ask&& ask) const {
    std::lock_guard lock(mutex_);
    return std::visit(std::forward<Ask>(ask), model_);
  }
  gp::Hyperparameters hyperparameters() const {
    return Visit([](const auto& model) { return model.hyperparameters(); });
  }
  egosieve_gp_info Describe() const;
  std::string annotation() const;
  DevicePosterior Posterior();
  // The same on these devices, which share its queries; made by each call.
  DevicePosterior PosteriorOn(const kernels::Contexts& devices) const;

 private:
  using Model = std::variant<gp::ExactModel, gp::SparseModel, gp::IterativeModel>;

  LearningModel(Model model, const kernels::DensePosteriorOptions& options);
  // Called under the lock: discards everything derived from the model.
  void Changed();
  // Calls `change` with the model, under the lock; renews: it leaves the factor renewed.
  template <typename Change>
  void Apply(Change&& change, bool renews = false) {
    std::lock_guard lock(mutex_);
    std::visit(std::forward<Change>(change), model_);
    Changed();
    is_renewed_ = renews;
  }

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

template <>
struct HandleOf<egosieve_gp> {
  using Object = LearningModel;
  static constexpr uint64_t kKind = 1;
  static constexpr char kName[] = "gp";
};

template <>
struct HandleOf<egosieve_posterior> {
  using Object = const DevicePosterior;
  static constexpr uint64_t kKind = 2;
  static constexpr char kName[] = "posterior";
};

}  // namespace egosieve::embed
