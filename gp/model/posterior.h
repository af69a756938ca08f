// The posterior of a Gaussian process at one moment. It is immutable and can be used from any
// number of threads while its model continues to learn.
//
//   mean, variance of f, probability as in kernels/ops/dense_posterior.h    (PO1)
//   variance of y = variance of f + sigma_n^2                               (PO2)
//
// Mean functions and several outputs add (W3), (W4) of gp/model/regression_weights.h. The device
// gives k*.alpha of one output and k** - |L^-1 k*|^2 in float32. The means of several outputs and
// the sums W^T k* need a separate pass over the covariances in float64, of n (D + 10 + k + q)
// multiply-adds per query.
//
// On several devices, queries are divided among them (kernels/ops/shared_posterior.h). The float64
// pass is that of the first.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

class Posterior {
 public:
  // The posterior of `model`, on one device or several; `model.squash_a` and `_b` are set from
  // `squash`.
  static absl::StatusOr<std::shared_ptr<const Posterior>> Create(
      const kernels::Contexts& contexts, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const kernels::DensePosteriorOptions& options = {});
  // The same with weights in place of `model.alpha`. FailedPrecondition if these do not determine
  // the mean function.
  static absl::StatusOr<std::shared_ptr<const Posterior>> Create(
      const kernels::Contexts& contexts, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const RegressionWeights& weights, const kernels::DensePosteriorOptions& options = {});

  // (PO1): queries M x D; outputs are the caller's arrays, null if not wanted: the mean of M x k
  // values, variance (of f) and probability of M. InvalidArgument for NaN or infinite queries, with
  // the row, and for the probability of several outputs; then nothing is written.
  absl::StatusOr<kernels::PosteriorCounts> Evaluate(kernels::ConstMatrixView<float> queries,
                                                    const kernels::PosteriorOutputs& outputs) const;
  // Queries in float64 are rounded only after they are prepared.
  absl::StatusOr<kernels::PosteriorCounts> Evaluate(kernels::ConstMatrixView<double> queries,
                                                    const kernels::PosteriorOutputs& outputs) const;

  // (PO1) on the caller's queue, as in kernels/ops/dense_posterior.h. FailedPrecondition for
  // several outputs and for mean functions, which need the host.
  absl::StatusOr<cl_event> Enqueue(const kernels::BufferMatrix& queries,
                                   const kernels::DeviceOutputs& outputs,
                                   const kernels::DeviceCall& call) const;

  // (PO2) from (PO1): the variance of an observation, in place.
  void AddNoiseVariance(absl::Span<float> latent_variances) const;

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const SquashParameters& squash() const { return squash_; }
  int64_t outputs() const { return extension_ == nullptr ? 1 : extension_->weights.outputs; }  // k
  int64_t size() const { return size_; }  // number of points (or inducing points)
  std::string description() const { return dense_->description(); }

 private:
  // For models with several outputs or a mean function.
  struct Extension {
    std::vector<double> inputs;  // n x D
    RegressionWeights weights;
  };

  Posterior() = default;

  static absl::StatusOr<std::shared_ptr<Posterior>> CreatePlain(
      const kernels::Contexts& contexts, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const kernels::DensePosteriorOptions& options);

  template <typename Query>
  absl::StatusOr<kernels::PosteriorCounts> EvaluateQueries(
      kernels::ConstMatrixView<Query> queries, const kernels::PosteriorOutputs& outputs) const;
  // The float64 pass: means of all outputs (M x k), and the variances' additional term |M^-1 r|^2
  // (M).
  template <typename Query>
  absl::Status EvaluateExtension(kernels::ConstMatrixView<Query> queries, float* means,
                                 double* added_variances) const;
  template <typename Query>
  absl::StatusOr<kernels::PosteriorCounts> EvaluateExtended(
      kernels::ConstMatrixView<Query> queries, const kernels::PosteriorOutputs& outputs) const;

  std::shared_ptr<kernels::Context> context_;  // the first
  Hyperparameters hyperparameters_;
  SquashParameters squash_;
  int64_t size_ = 0;
  std::unique_ptr<kernels::DensePosterior> dense_;
  std::unique_ptr<const Extension> extension_;
};

}  // namespace egosieve::gp
