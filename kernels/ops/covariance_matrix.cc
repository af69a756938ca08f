#include "kernels/ops/covariance_matrix.h"

#include <utility>

#include "kernels/base/argument_checks.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_covariance.h"
#include "kernels/reference/covariance.h"
#include "kernels/runtime/fork_guard.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

bool RunsOnHost(const Context& context) {
  return context.is_reference() || !context.info().float64;
}

}  // namespace

absl::Status CovarianceMatrix(Context& context, const CovarianceParameters& parameters,
                              ConstMatrixView<double> x, double noise_variance, Triangle triangle,
                              MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, x.rows));
  EGOSIEVE_RETURN_IF_ERROR(
      CheckOptions({{"noise_variance", noise_variance, IsNotNegative(noise_variance),
                     "be finite and at least 0"}}));
  const bool lower_only = triangle == Triangle::kLower;
  if (RunsOnHost(context)) {
    reference::CovarianceBlock(parameters, x, x, lower_only, out);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(opencl::CovarianceBlock(context, parameters, x, x, lower_only, out));
  }
  for (int64_t i = 0; i < out.rows; ++i) out(i, i) += noise_variance;
  return absl::OkStatus();
}

absl::Status CrossCovariance(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z,
                             MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("z", parameters, z));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, z.rows));
  if (RunsOnHost(context)) {
    reference::CovarianceBlock(parameters, x, z, false, out);
    return absl::OkStatus();
  }
  return opencl::CovarianceBlock(context, parameters, x, z, false, out);
}

absl::StatusOr<cl_event> EnqueueCrossCovariance(std::shared_ptr<Context> context,
                                                const CovarianceParameters& parameters,
                                                const BufferMatrix& x, const BufferMatrix& z,
                                                const BufferMatrix& k, const DeviceCall& call) {
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  if (context->is_reference()) {
    return absl::FailedPreconditionError("the device \"reference\" has no OpenCL context");
  }
  return opencl::EnqueueCovarianceBlock(std::move(context), parameters, x, z, k, call);
}

}  // namespace egosieve::kernels
