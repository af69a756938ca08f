#include "gp/model/posterior.h"

#include <algorithm>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/linalg/aligned_matrix.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/shared_posterior.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

constexpr int64_t kQueryTile = 512;  // queries at a time

// M x D in float64.
template <typename Query>
std::vector<double> WideRows(ConstMatrixView<Query> queries, int64_t begin, int64_t end) {
  std::vector<double> wide((end - begin) * queries.cols);
  for (int64_t i = begin; i < end; ++i) {
    std::copy_n(queries.row(i), queries.cols, &wide[(i - begin) * queries.cols]);
  }
  return wide;
}

}  // namespace

absl::StatusOr<std::shared_ptr<Posterior>> Posterior::CreatePlain(
    const kernels::Contexts& contexts, kernels::PosteriorModel model,
    const Hyperparameters& hyperparameters, const SquashParameters& squash,
    const kernels::DensePosteriorOptions& options) {
  model.squash_a = squash.a;
  model.squash_b = squash.b;
  std::shared_ptr<Posterior> posterior(new Posterior);
  EGOSIEVE_ASSIGN_OR_RETURN(posterior->dense_,
                            kernels::CreateSharedPosterior(contexts, model, options));
  posterior->context_ = contexts.front();
  posterior->hyperparameters_ = hyperparameters;
  posterior->squash_ = squash;
  posterior->size_ = model.inputs.rows;
  return posterior;
}

absl::StatusOr<std::shared_ptr<const Posterior>> Posterior::Create(
    const kernels::Contexts& contexts, kernels::PosteriorModel model,
    const Hyperparameters& hyperparameters, const SquashParameters& squash,
    const kernels::DensePosteriorOptions& options) {
  return CreatePlain(contexts, std::move(model), hyperparameters, squash, options);
}

absl::StatusOr<std::shared_ptr<const Posterior>> Posterior::Create(
    const kernels::Contexts& contexts, kernels::PosteriorModel model,
    const Hyperparameters& hyperparameters, const SquashParameters& squash,
    const RegressionWeights& weights, const kernels::DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(weights.CheckDetermined());
  std::vector<double> first(weights.outputs == 1 ? 0 : weights.points);
  for (size_t i = 0; i < first.size(); ++i) first[i] = weights.alpha[i * weights.outputs];
  model.alpha = weights.outputs == 1 ? weights.alpha.data() : first.data();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<Posterior> posterior,
                            CreatePlain(contexts, model, hyperparameters, squash, options));
  if (weights.outputs > 1 || weights.basis > 0) {
    auto extension = std::make_unique<Extension>();
    const int64_t dimension = hyperparameters.covariance.input_dimension();
    for (int64_t i = 0; i < model.inputs.rows; ++i) {
      const double* x = model.inputs.row(i);
      extension->inputs.insert(extension->inputs.end(), x, x + dimension);
    }
    extension->weights = weights;
    posterior->extension_ = std::move(extension);
  }
  return std::shared_ptr<const Posterior>(posterior);
}

absl::StatusOr<kernels::PosteriorCounts> Posterior::Evaluate(
    ConstMatrixView<float> queries, const kernels::PosteriorOutputs& outputs) const {
  return EvaluateQueries(queries, outputs);
}

absl::StatusOr<kernels::PosteriorCounts> Posterior::Evaluate(
    ConstMatrixView<double> queries, const kernels::PosteriorOutputs& outputs) const {
  return EvaluateQueries(queries, outputs);
}

template <typename Query>
absl::StatusOr<kernels::PosteriorCounts> Posterior::EvaluateQueries(
    ConstMatrixView<Query> queries, const kernels::PosteriorOutputs& outputs) const {
  if (extension_ == nullptr) return dense_->Evaluate(queries, outputs);
  if (outputs.probability != nullptr && extension_->weights.outputs > 1) {
    return absl::InvalidArgumentError("probabilities are of one output; this model has several");
  }
  return EvaluateExtended(queries, outputs);
}

absl::StatusOr<cl_event> Posterior::Enqueue(const kernels::BufferMatrix& queries,
                                            const kernels::DeviceOutputs& outputs,
                                            const kernels::DeviceCall& call) const {
  if (extension_ != nullptr) {
    return absl::FailedPreconditionError(
        "models of several outputs or with a mean function are not evaluated on a queue");
  }
  return dense_->Enqueue(queries, outputs, call);
}

template <typename Query>
absl::StatusOr<kernels::PosteriorCounts> Posterior::EvaluateExtended(
    ConstMatrixView<Query> queries, const kernels::PosteriorOutputs& outputs) const {
  const RegressionWeights& weights = extension_->weights;
  const int64_t dimension = hyperparameters_.covariance.input_dimension();
  const bool wants_variance = outputs.variance != nullptr || outputs.probability != nullptr;
  const bool wants_mean = outputs.mean != nullptr || outputs.probability != nullptr;
  // Nothing is written before all results exist.
  std::vector<float> means(wants_mean ? queries.rows * weights.outputs : 0);
  std::vector<float> variances(wants_variance ? queries.rows : 0);
  kernels::PosteriorOutputs dense;
  if (wants_mean && weights.outputs == 1) dense.mean = means.data();
  if (wants_variance) dense.variance = variances.data();
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::PosteriorCounts counts,
                            dense_->Evaluate(queries, dense));
  if (weights.outputs == 1) {
    for (size_t i = 0; i < means.size(); ++i) {
      double mean = means[i];
      weights.AddMeanFunction(dimension, queries.row(i), &mean);
      means[i] = static_cast<float>(mean);
    }
  }
  const bool adds_variance = wants_variance && weights.basis > 0;
  const bool makes_means = wants_mean && weights.outputs > 1;
  if (adds_variance || makes_means) {
    std::vector<double> added(adds_variance ? queries.rows : 0);
    EGOSIEVE_RETURN_IF_ERROR(EvaluateExtension(queries, makes_means ? means.data() : nullptr,
                                               adds_variance ? added.data() : nullptr));
    for (size_t i = 0; i < added.size(); ++i) variances[i] += static_cast<float>(added[i]);
  }
  if (outputs.mean != nullptr) std::copy(means.begin(), means.end(), outputs.mean);
  if (outputs.variance != nullptr) std::copy(variances.begin(), variances.end(), outputs.variance);
  for (int64_t i = 0; outputs.probability != nullptr && i < queries.rows; ++i) {
    outputs.probability[i] = static_cast<float>(squash_.Probability(means[i], variances[i]));
  }
  return counts;
}

template <typename Query>
absl::Status Posterior::EvaluateExtension(ConstMatrixView<Query> queries, float* means,
                                          double* added_variances) const {
  const RegressionWeights& weights = extension_->weights;
  const int64_t dimension = hyperparameters_.covariance.input_dimension();
  const ConstMatrixView<double> inputs(extension_->inputs.data(), size_, dimension);
  AlignedMatrix cross(std::min(kQueryTile, queries.rows), size_);
  for (int64_t begin = 0; begin < queries.rows; begin += kQueryTile) {
    const int64_t end = std::min(begin + kQueryTile, queries.rows);
    const std::vector<double> wide = WideRows(queries, begin, end);
    const ConstMatrixView<double> points(wide.data(), end - begin, dimension);
    EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(
        *context_, hyperparameters_.covariance, points, inputs, cross.block(points.rows, size_)));
    const double flops = 2.0 * points.rows * size_ * (weights.outputs + weights.basis);
    kernels::ParallelFor(points.rows, flops, [&](int64_t i) {
      absl::FixedArray<double, 64> sums(std::max(weights.outputs, 2 * weights.basis));
      if (means != nullptr) {
        WeightedSums(cross.row(i), weights.alpha, size_, weights.outputs, sums.data());
        weights.AddMeanFunction(dimension, points.row(i), sums.data());
        std::copy_n(sums.begin(), weights.outputs, means + (begin + i) * weights.outputs);
      }
      if (added_variances != nullptr) {
        WeightedSums(cross.row(i), weights.basis_weights, size_, weights.basis, sums.data());
        added_variances[begin + i] = weights.ReducedBasis(dimension, points.row(i), sums.data(),
                                                          sums.data() + weights.basis);
      }
    });
  }
  return absl::OkStatus();
}

void Posterior::AddNoiseVariance(absl::Span<float> latent_variances) const {
  const float noise = static_cast<float>(hyperparameters_.noise_variance());
  for (float& variance : latent_variances) variance += noise;
}

}  // namespace egosieve::gp
