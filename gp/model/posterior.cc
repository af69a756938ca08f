#include "gp/model/posterior.h"

#include <algorithm>

#include "gp/model/point_set.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

constexpr int64_t kWideRows = 16384;  // queries in float64 at a time

}  // namespace

absl::StatusOr<std::shared_ptr<const Posterior>> Posterior::Create(
    const kernels::Contexts& contexts, const Hyperparameters& hyperparameters,
    ConstMatrixView<double> inputs, const RegressionWeights& weights, const SharedFactor& factor,
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(weights.CheckDetermined());
  std::vector<double> first(weights.outputs == 1 ? 0 : weights.points);
  for (size_t i = 0; i < first.size(); ++i) first[i] = weights.alpha[i * weights.outputs];
  kernels::PosteriorModel model;
  model.covariance = hyperparameters.covariance;
  model.inputs = inputs;
  model.alpha = weights.outputs == 1 ? weights.alpha.data() : first.data();
  model.factor_kind = factor.kind;
  model.factor = factor.values;
  model.squash_a = squash.a;
  model.squash_b = squash.b;
  std::shared_ptr<Posterior> posterior(new Posterior);
  EGOSIEVE_ASSIGN_OR_RETURN(posterior->dense_,
                            kernels::CreateSharedPosterior(contexts, model, options));
  posterior->hyperparameters_ = hyperparameters;
  posterior->squash_ = squash;
  if (weights.outputs > 1 || weights.basis > 0) {
    posterior->extension_ = std::make_unique<const Float64Posterior>(
        contexts.front(), hyperparameters, inputs, weights,
        SharedFactor{kernels::FactorKind::kNone, {nullptr, inputs.rows, inputs.rows}, nullptr});
  }
  return posterior;
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
  const RegressionWeights& weights = extension_->weights();
  EGOSIEVE_REQUIRE(InvalidArgument, outputs.probability == nullptr || weights.outputs == 1,
                   "probabilities are of one output; this model has several");
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
      weights.AddMeanFunction(queries.cols, queries.row(i), &mean);
      means[i] = static_cast<float>(mean);
    }
  }
  const bool makes_means = wants_mean && weights.outputs > 1;
  const bool adds_variance = wants_variance && weights.basis > 0;
  std::vector<double> sums, added;
  for (int64_t begin = 0; (makes_means || adds_variance) && begin < queries.rows;
       begin += kWideRows) {
    const auto some = queries.rows_between(begin, std::min(begin + kWideRows, queries.rows));
    const std::vector<double> wide = Widen(some);
    sums.resize(makes_means ? some.rows * weights.outputs : 0);
    added.resize(adds_variance ? some.rows : 0);
    EGOSIEVE_RETURN_IF_ERROR(extension_->EvaluateWeights({wide.data(), some.rows, some.cols},
                                                         makes_means ? sums.data() : nullptr,
                                                         adds_variance ? added.data() : nullptr));
    std::copy(sums.begin(), sums.end(), means.begin() + begin * weights.outputs);
    for (size_t i = 0; i < added.size(); ++i) variances[begin + i] += static_cast<float>(added[i]);
  }
  if (outputs.mean != nullptr) std::copy(means.begin(), means.end(), outputs.mean);
  if (outputs.variance != nullptr) std::copy(variances.begin(), variances.end(), outputs.variance);
  for (int64_t i = 0; outputs.probability != nullptr && i < queries.rows; ++i) {
    outputs.probability[i] = static_cast<float>(squash_.Probability(means[i], variances[i]));
  }
  return counts;
}

absl::StatusOr<cl_event> Posterior::Enqueue(const kernels::BufferMatrix& queries,
                                            const kernels::DeviceOutputs& outputs,
                                            const kernels::DeviceCall& call) const {
  EGOSIEVE_REQUIRE(
      FailedPrecondition, extension_ == nullptr,
      "models of several outputs or with a mean function are not evaluated on a queue");
  return dense_->Enqueue(queries, outputs, call);
}

}  // namespace egosieve::gp
