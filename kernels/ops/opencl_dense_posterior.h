// The dense posterior on an OpenCL device, and what all posteriors share.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "kernels/base/aligned_array.h"
#include "kernels/ops/dense_posterior.h"

namespace egosieve::kernels {

// InvalidArgument, naming the first bad row, unless queries has `dimension` columns and finite
// values.
template <typename Query>
absl::Status CheckQueries(int64_t dimension, ConstMatrixView<Query> queries);

// FailedPrecondition if variances are requested of a model without a factor.
absl::Status CheckOutputs(bool needs_variance, FactorKind factor_kind, int64_t input_count);

// Holds results until all of them exist, since a device may fail in any chunk.
class StagedOutputs {
 public:
  StagedOutputs(const PosteriorOutputs& outputs, int64_t count)
      : count_(count), targets_{outputs.mean, outputs.variance, outputs.probability} {
    for (int i = 0; i < 3; ++i) {
      if (targets_[i] != nullptr) values_[i] = AlignedArray<float>(count);
    }
  }

  PosteriorOutputs From(int64_t first) {
    const auto at = [&](int i) { return targets_[i] ? values_[i].data() + first : nullptr; };
    return {at(0), at(1), at(2)};
  }

  void Commit() {
    for (int i = 0; i < 3; ++i) {
      if (targets_[i] != nullptr) std::copy_n(values_[i].data(), count_, targets_[i]);
    }
  }

 private:
  int64_t count_;
  std::array<float*, 3> targets_;
  std::array<AlignedArray<float>, 3> values_;
};

namespace opencl {

// `model` and `options` must be valid.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateDensePosterior(
    std::shared_ptr<Context> context, const PosteriorModel& model,
    const DensePosteriorOptions& options);

}  // namespace opencl
}  // namespace egosieve::kernels
