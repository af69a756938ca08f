#include "gp/model/posterior.h"

#include <utility>

namespace egosieve::gp {

absl::StatusOr<std::shared_ptr<const Posterior>> Posterior::Create(
    std::shared_ptr<kernels::Context> context, kernels::PosteriorModel model,
    const Hyperparameters& hyperparameters, const SquashParameters& squash,
    const kernels::DensePosteriorOptions& options) {
  model.squash_a = squash.a;
  model.squash_b = squash.b;
  auto dense = kernels::DensePosterior::Create(std::move(context), model, options);
  if (!dense.ok()) return std::move(dense).status();
  std::shared_ptr<Posterior> posterior(new Posterior);
  posterior->hyperparameters_ = hyperparameters;
  posterior->squash_ = squash;
  posterior->size_ = model.inputs.rows;
  posterior->dense_ = *std::move(dense);
  return std::shared_ptr<const Posterior>(std::move(posterior));
}

absl::StatusOr<kernels::PosteriorCounts> Posterior::Evaluate(
    kernels::ConstMatrixView<float> queries, const kernels::PosteriorOutputs& outputs) const {
  return dense_->Evaluate(queries, outputs);
}

void Posterior::AddNoiseVariance(absl::Span<float> latent_variances) const {
  const float noise = static_cast<float>(hyperparameters_.noise_variance());
  for (float& variance : latent_variances) variance += noise;
}

}  // namespace egosieve::gp
