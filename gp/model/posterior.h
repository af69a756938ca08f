// What a Gaussian process believes at one moment: immutable, safe to use from any number of threads
// while the model that made it goes on learning.
//
//   mean, variance of f, probability as in kernels/ops/dense_posterior.h    (PO1)
//   variance of y = variance of f + sigma_n^2                               (PO2)
//
// Mean functions and several outputs add (W3), (W4) of gp/model/regression_weights.h. The device
// gives k*.alpha of one output and k** - |L^-1 k*|^2 in float32; the means of several outputs and
// the sums W^T k* come from a pass of their own over the covariances, in float64, of n (D + 10 + k
// + q) multiply-adds a query.
#ifndef EGOSIEVE_GP_MODEL_POSTERIOR_H_
#define EGOSIEVE_GP_MODEL_POSTERIOR_H_

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

namespace egosieve::gp {

class Posterior {
 public:
  // Takes what `model` describes; `model.squash_a` and `_b` are set from `squash`.
  static absl::StatusOr<std::shared_ptr<const Posterior>> Create(
      std::shared_ptr<kernels::Context> context, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const kernels::DensePosteriorOptions& options = {});
  // The same with weights in place of `model.alpha`. FailedPrecondition where these do not
  // determine the mean function.
  static absl::StatusOr<std::shared_ptr<const Posterior>> Create(
      std::shared_ptr<kernels::Context> context, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const RegressionWeights& weights, const kernels::DensePosteriorOptions& options = {});

  // (PO1): queries M x D; outputs are the caller's arrays, null where not wanted: the mean of M x k
  // values, variance (of f) and probability of M. InvalidArgument on NaN or infinite queries,
  // naming the row, and for the probability of several outputs; nothing is written then.
  absl::StatusOr<kernels::PosteriorCounts> Evaluate(kernels::ConstMatrixView<float> queries,
                                                    const kernels::PosteriorOutputs& outputs) const;

  // (PO1) on the caller's queue, as in kernels/ops/dense_posterior.h. FailedPrecondition for
  // several outputs and mean functions, which need the host.
  absl::StatusOr<cl_event> Enqueue(const kernels::DeviceQueries& queries,
                                   const kernels::DeviceOutputs& outputs,
                                   const kernels::DeviceCall& call) const;

  // (PO2) from (PO1): the variance of an observation, in place.
  void AddNoiseVariance(absl::Span<float> latent_variances) const;

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const SquashParameters& squash() const { return squash_; }
  int64_t outputs() const { return extension_ == nullptr ? 1 : extension_->weights.outputs; }  // k
  int64_t size() const { return size_; }  // points (or inducing points) behind it
  std::string description() const { return dense_->description(); }

 private:
  // Of models with several outputs or a mean function.
  struct Extension {
    std::vector<double> inputs;  // n x D
    RegressionWeights weights;
  };

  Posterior() = default;

  static absl::StatusOr<std::shared_ptr<Posterior>> CreatePlain(
      std::shared_ptr<kernels::Context> context, kernels::PosteriorModel model,
      const Hyperparameters& hyperparameters, const SquashParameters& squash,
      const kernels::DensePosteriorOptions& options);

  // The float64 pass: means of all outputs (M x k), and what |M^-1 r|^2 adds to the variances (M).
  absl::Status EvaluateExtension(kernels::ConstMatrixView<float> queries, float* means,
                                 double* added_variances) const;
  absl::StatusOr<kernels::PosteriorCounts> EvaluateExtended(
      kernels::ConstMatrixView<float> queries, const kernels::PosteriorOutputs& outputs) const;

  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  SquashParameters squash_;
  int64_t size_ = 0;
  std::unique_ptr<kernels::DensePosterior> dense_;
  std::unique_ptr<const Extension> extension_;
};

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_POSTERIOR_H_
