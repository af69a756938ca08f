// What a Gaussian process believes at one moment: immutable, safe to use from any number of threads
// while the model that made it goes on learning.
//
//   mean, variance of f, probability as in kernels/ops/dense_posterior.h     (P1)
//   variance of y = variance of f + sigma_n^2                                (P2)
#ifndef EGOSIEVE_GP_MODEL_POSTERIOR_H_
#define EGOSIEVE_GP_MODEL_POSTERIOR_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
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

  // (P1): queries M x D; outputs are the caller's arrays of M, null where not wanted. The variance
  // is of f. InvalidArgument on NaN or infinite queries, naming the row; nothing is written then.
  absl::StatusOr<kernels::PosteriorCounts> Evaluate(kernels::ConstMatrixView<float> queries,
                                                    const kernels::PosteriorOutputs& outputs) const;

  // (P2) from (P1): the variance of an observation, in place.
  void AddNoiseVariance(absl::Span<float> latent_variances) const;

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const SquashParameters& squash() const { return squash_; }
  int64_t size() const { return size_; }  // points (or inducing points) behind it
  std::string description() const { return dense_->description(); }

 private:
  Posterior() = default;

  Hyperparameters hyperparameters_;
  SquashParameters squash_;
  int64_t size_ = 0;
  std::unique_ptr<kernels::DensePosterior> dense_;
};

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_POSTERIOR_H_
