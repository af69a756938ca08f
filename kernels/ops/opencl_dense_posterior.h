// The dense posterior on an OpenCL device.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "kernels/ops/dense_posterior.h"

namespace egosieve::kernels {

// InvalidArgument, naming the first bad row, unless queries has `dimension` columns and finite
// values.
template <typename Query>
absl::Status CheckQueries(int64_t dimension, ConstMatrixView<Query> queries);

// FailedPrecondition if variances are requested of a model without a factor.
absl::Status CheckOutputs(bool needs_variance, FactorKind factor_kind, int64_t input_count);

namespace opencl {

// `model` and `options` must be valid.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateDensePosterior(
    std::shared_ptr<Context> context, const PosteriorModel& model,
    const DensePosteriorOptions& options);

}  // namespace opencl
}  // namespace egosieve::kernels
