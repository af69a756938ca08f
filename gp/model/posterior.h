// The posterior of a Gaussian process at one moment. It is immutable and can be used from any
// number of threads while its model continues to learn.
//
//   mean, variance of f, probability as in kernels/ops/dense_posterior.h    (PO1)
//
// Mean functions and several outputs add (W3), (W4) of gp/model/regression_weights.h. The device
// gives k*.alpha of one output and k** - |L^-1 k*|^2 in float32. The means of several outputs and
// the sums W^T k* need a separate pass over the covariances in float64, of n (D + 10 + k + q)
// multiply-adds per query.
//
// On several devices, queries are divided among them (CreateSharedPosterior). The float64
// pass is that of the first.
#pragma once

#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/float64_posterior.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

class Posterior {
 public:
  // On one device or several. inputs: n x D. FailedPrecondition if the weights do not determine the
  // mean function.
  static absl::StatusOr<std::shared_ptr<const Posterior>> Create(
      const kernels::Contexts& contexts, const Hyperparameters& hyperparameters,
      kernels::ConstMatrixView<double> inputs, const RegressionWeights& weights,
      const SharedFactor& factor, const SquashParameters& squash,
      const kernels::DensePosteriorOptions& options = {});

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

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const SquashParameters& squash() const { return squash_; }
  int64_t outputs() const { return extension_ == nullptr ? 1 : extension_->outputs(); }  // k

 private:
  Posterior() = default;

  template <typename Query>
  absl::StatusOr<kernels::PosteriorCounts> EvaluateQueries(
      kernels::ConstMatrixView<Query> queries, const kernels::PosteriorOutputs& outputs) const;
  Hyperparameters hyperparameters_;
  SquashParameters squash_;
  std::unique_ptr<kernels::DensePosterior> dense_;
  // Of several outputs or a mean function, on the first device: sums over covariances in float64.
  std::unique_ptr<const Float64Posterior> extension_;
};

}  // namespace egosieve::gp
