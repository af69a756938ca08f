// What exact, sparse and iterative models have in common: points, hyperparameters and posteriors.
//
//   y_i = 2 p_i - 1 for a label p_i in [0, 1]; else any targets, of k outputs                 (RM1)
//
// Points keep the order in which they were added; removal closes the gaps. Every point has an
// identity, which is unique and increasing over the model's lifetime, and the time at which it was
// added, in the caller's unit.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/float64_posterior.h"
#include "gp/model/point_set.h"
#include "gp/model/posterior.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// A model as a value: everything that is not computed from it.
struct ExactModelState {
  Hyperparameters hyperparameters;
  PointSet points;

  absl::Status Validate() const;
};

// Checks that all models share.
// InvalidArgument if there is no context or the hyperparameters are invalid.
absl::Status CheckSetUp(const kernels::Context* context, const Hyperparameters& hyperparameters);

// Unimplemented, naming the kind of model, for mean functions but zero.
absl::Status CheckZeroMean(const char* kind, const Hyperparameters& hyperparameters);

// InvalidArgument unless the hyperparameters are valid and fit a model with `size` points of
// `dimension` inputs.
absl::Status CheckReplacement(const Hyperparameters& hyperparameters, int64_t size,
                              int64_t dimension);

// InvalidArgument unless the observations are valid and have as many outputs as the model's points,
// if there are any.
absl::Status CheckAddition(const Observations& added, const PointSet& points, int64_t dimension);

// Replaces the targets of the points. InvalidArgument, unchanged, unless the numbers of points and
// outputs are as before and all targets finite.
absl::Status ReplaceTargets(kernels::ConstMatrixView<double> targets, int64_t dimension,
                            PointSet& points);

class RegressionModel {
 public:
  // inputs: N x D, finite; labels: N, in [0, 1]; otherwise InvalidArgument with row and value.
  // Unchanged after an error. N = 0 is no change.
  absl::Status Add(kernels::ConstMatrixView<double> inputs, absl::Span<const double> labels,
                   int64_t time);
  // For regression: any finite targets y, of one output or several, with noise by point. The number
  // of outputs must be that of the model's points.
  virtual absl::Status AddObservations(const Observations& added, int64_t time) = 0;

  // The argument of Restore; gp/io/model_file.h stores it.
  ExactModelState State() const { return {hyperparameters_, points_}; }

  int64_t size() const { return points_.size(); }
  int64_t input_dimension() const { return hyperparameters_.covariance.input_dimension(); }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const std::shared_ptr<kernels::Context>& context() const { return context_; }

  // Views are valid until the next change.
  const PointSet& points() const { return points_; }
  kernels::ConstMatrixView<double> inputs() const { return points_.view(input_dimension()); }
  absl::Span<const double> targets() const { return points_.targets; }  // n x k; for labels 2 p - 1
  int64_t outputs() const { return points_.outputs; }                   // k
  Observations observations() const { return points_.observations(input_dimension()); }
  absl::Span<const int64_t> insertion_times() const { return points_.insertion_times; }

  // An immutable posterior of the present model. The model is unchanged; the cost is an upload, and
  // for several outputs or mean functions also a copy of the inputs. devices: what it lies on, in
  // place of the model's own context; empty: that one.
  absl::StatusOr<std::shared_ptr<const Posterior>> MakePosterior(
      const SquashParameters& squash, const kernels::DensePosteriorOptions& options = {},
      const kernels::Contexts& devices = {}) const;
  // The same in float64, on the model's own context, which also predicts jointly. It shares the
  // factor until a change of its rows.
  absl::StatusOr<std::shared_ptr<const Float64Posterior>> MakeFloat64Posterior() const;

 protected:
  RegressionModel() = default;
  RegressionModel(std::shared_ptr<kernels::Context> context, const Hyperparameters& hyperparameters)
      : context_(std::move(context)), hyperparameters_(hyperparameters) {}
  RegressionModel(RegressionModel&&) = default;
  RegressionModel& operator=(RegressionModel&&) = default;
  ~RegressionModel() = default;

  // What posteriors are made of: inputs, the weights of their covariances, and the factor; what the
  // factor's `memory` holds keeps all three.
  struct PosteriorParts {
    kernels::ConstMatrixView<double> inputs;
    const RegressionWeights* weights = nullptr;
    SharedFactor factor;
  };
  virtual absl::StatusOr<PosteriorParts> Parts() const = 0;

  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  PointSet points_;
};

}  // namespace egosieve::gp
