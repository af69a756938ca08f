#include "kernels/ops/dense_posterior.h"

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_dense_posterior.h"
#include "kernels/reference/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

class HostPosterior : public DensePosterior {
 public:
  explicit HostPosterior(const PosteriorModel& model)
      : dimension_(model.covariance.input_dimension()),
        count_(model.inputs.rows),
        factor_kind_(model.factor_kind),
        posterior_(model) {}

  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<float> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }
  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<double> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }

  absl::StatusOr<cl_event> Enqueue(const BufferMatrix&, const DeviceOutputs&,
                                   const DeviceCall&) const override {
    return absl::FailedPreconditionError("the reference has no queues: open an OpenCL device");
  }

 private:
  template <typename Query>
  absl::StatusOr<PosteriorCounts> EvaluateQueries(ConstMatrixView<Query> queries,
                                                  const PosteriorOutputs& outputs) const {
    EGOSIEVE_RETURN_IF_ERROR(CheckQueries(dimension_, queries));
    EGOSIEVE_RETURN_IF_ERROR(CheckOutputs(
        outputs.variance != nullptr || outputs.probability != nullptr, factor_kind_, count_));
    return PosteriorCounts{
        posterior_.Evaluate(queries, outputs.mean, outputs.variance, outputs.probability)};
  }

  int64_t dimension_;
  int64_t count_;
  FactorKind factor_kind_;
  reference::DensePosterior posterior_;
};

}  // namespace

absl::Status DensePosteriorOptions::Validate() const {
  EGOSIEVE_REQUIRE(InvalidArgument, memory_cap_bytes >= 0,
                   "memory_cap_bytes = %d; it must not be negative", memory_cap_bytes);
  return absl::OkStatus();
}

template <typename Query>
absl::Status CheckQueries(int64_t dimension, ConstMatrixView<Query> queries) {
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("queries", queries, queries.rows, dimension));
  return CheckFinite("queries", queries);
}
template absl::Status CheckQueries(int64_t, ConstMatrixView<float>);
template absl::Status CheckQueries(int64_t, ConstMatrixView<double>);

absl::Status CheckOutputs(bool needs_variance, FactorKind factor_kind, int64_t input_count) {
  EGOSIEVE_REQUIRE(
      FailedPrecondition, !needs_variance || factor_kind != FactorKind::kNone || input_count == 0,
      "variance and probability need a factor: this model was created with factor_kind kNone");
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<DensePosterior>> DensePosterior::Create(
    std::shared_ptr<Context> context, const PosteriorModel& model,
    const DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(model.Validate());
  EGOSIEVE_REQUIRE(InvalidArgument, context != nullptr,
                   "context is null; open one with OpenContext");
  if (context->is_reference()) {
    return std::make_unique<HostPosterior>(model);
  }
  return opencl::CreateDensePosterior(std::move(context), model, options);
}

}  // namespace egosieve::kernels
