#include "kernels/ops/float64_sums.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/base/argument_checks.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/device_linear_algebra.h"
#include "kernels/ops/opencl_covariance.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace {

using opencl::CovarianceKernels;
using opencl::CovariancePoints;
using opencl::DeviceFactor;
using opencl::DeviceLinearAlgebra;
using opencl::DeviceMatrix;

constexpr char kDoing[] = "predicting in float64 on the device";
constexpr int64_t kChunkValues = int64_t{1} << 25;
constexpr int64_t kLeastQueries = 64, kMostQueries = 8192;  // of a chunk

class DeviceSums final : public Float64Sums {
 public:
  DeviceSums(std::shared_ptr<Context> context, const CovarianceParameters& covariance,
             ConstMatrixView<double> inputs, int64_t weights, FactorKind kind)
      : context_(std::move(context)),
        covariance_(covariance),
        inputs_(inputs),
        weight_count_(weights),
        kind_(kind) {}

  absl::Status Upload(ConstMatrixView<double> weights, ConstMatrixView<double> factor) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context_->Borrow(kDoing));
    EGOSIEVE_ASSIGN_OR_RETURN(DeviceLinearAlgebra algebra,
                              DeviceLinearAlgebra::Create(*context_, *workspace));
    EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
      weights_ = algebra.Upload(weights);
      if (kind_ == FactorKind::kCholesky) factor_ = algebra.UploadFactor(factor);
      if (kind_ == FactorKind::kInverseCholesky) factor_.lower = algebra.UploadLower(factor);
    }));
    context_->GiveBack(std::move(workspace));
    return absl::OkStatus();
  }

  absl::Status Evaluate(ConstMatrixView<double> queries, MatrixView<double> sums,
                        double* norms) const override {
    EGOSIEVE_RETURN_IF_ERROR(CheckPoints("queries", covariance_, queries));
    EGOSIEVE_RETURN_IF_ERROR(CheckShape("sums", sums, queries.rows, weight_count_));
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context_->Borrow(kDoing));
    EGOSIEVE_ASSIGN_OR_RETURN(DeviceLinearAlgebra algebra,
                              DeviceLinearAlgebra::Create(*context_, *workspace));
    EGOSIEVE_ASSIGN_OR_RETURN(
        CovarianceKernels covariances,
        CovarianceKernels::Create(*context_, *workspace, covariance_, CovarianceKernels::kBlock));
    const int64_t chunk = std::clamp(kChunkValues / inputs_.rows / kLeastQueries * kLeastQueries,
                                     kLeastQueries, kMostQueries);
    for (int64_t begin = 0; begin < queries.rows; begin += chunk) {
      const ConstMatrixView<double> of_chunk =
          queries.rows_between(begin, std::min(begin + chunk, queries.rows));
      EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
        EvaluateChunk(workspace->queue(), algebra, covariances, of_chunk,
                      {sums.row(begin), of_chunk.rows, sums.cols, sums.stride},
                      norms == nullptr ? nullptr : norms + begin);
      }));
    }
    context_->GiveBack(std::move(workspace));
    return absl::OkStatus();
  }

 private:
  // Throws cl::Error.
  void EvaluateChunk(const cl::CommandQueue& queue, DeviceLinearAlgebra& algebra,
                     CovarianceKernels& covariances, ConstMatrixView<double> queries,
                     MatrixView<double> sums, double* norms) const {
    const CovariancePoints points(*context_, covariance_, inputs_, queries);
    std::vector<double> found(weight_count_ * queries.rows);
    const CommandsEnd end(queue);
    DeviceMatrix cross = opencl::NewDeviceMatrix(*context_, inputs_.rows, queries.rows);
    covariances.EnqueueBlock(queue, points.block(), /*lower_only=*/false, cross.buffer, 0,
                             queries.rows);
    const DeviceMatrix products = algebra.MultiplyTransposed(weights_, cross);
    queue.enqueueReadBuffer(products.buffer, CL_TRUE, 0, found.size() * sizeof(double),
                            found.data());
    for (int64_t c = 0; c < weight_count_; ++c) {
      for (int64_t i = 0; i < queries.rows; ++i) sums(i, c) = found[c * queries.rows + i];
    }
    if (norms == nullptr) return;
    if (kind_ == FactorKind::kCholesky) {
      algebra.SolveLower(factor_, cross);
    } else {
      cross = algebra.MultiplyLower(factor_.lower, cross);
    }
    const DeviceMatrix squares = algebra.ColumnNorms(cross);
    queue.enqueueReadBuffer(squares.buffer, CL_TRUE, 0, queries.rows * sizeof(double), norms);
  }

  std::shared_ptr<Context> context_;
  CovarianceParameters covariance_;
  ConstMatrixView<double> inputs_;
  int64_t weight_count_;
  FactorKind kind_;
  DeviceMatrix weights_;
  DeviceFactor factor_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<const Float64Sums>> Float64Sums::Create(
    std::shared_ptr<Context> context, const CovarianceParameters& covariance,
    ConstMatrixView<double> inputs, ConstMatrixView<double> weights, FactorKind kind,
    ConstMatrixView<double> factor) {
  EGOSIEVE_RETURN_IF_ERROR(covariance.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("inputs", inputs, inputs.rows, covariance.input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("weights", weights, inputs.rows, weights.cols));
  EGOSIEVE_REQUIRE(InvalidArgument, inputs.rows >= 1 && weights.cols >= 1,
                   "sums need inputs and weights");
  if (kind != FactorKind::kNone) {
    EGOSIEVE_RETURN_IF_ERROR(CheckShape("factor", factor, inputs.rows, inputs.rows));
  }
  EGOSIEVE_REQUIRE(FailedPrecondition, !context->is_reference(),
                   "the reference has no device: open an OpenCL device");
  auto sums =
      std::make_unique<DeviceSums>(std::move(context), covariance, inputs, weights.cols, kind);
  EGOSIEVE_RETURN_IF_ERROR(sums->Upload(weights, factor));
  return sums;
}

}  // namespace egosieve::kernels
