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

template <typename T>
bool RunsOnHost(const Context& context) {
  return context.is_reference() || (sizeof(T) == sizeof(double) && !context.info().float64);
}

template <typename T>
void AddNoise(double noise_variance, MatrixView<T> out) {
  for (int64_t i = 0; i < out.rows; ++i) {
    out(i, i) = static_cast<T>(out(i, i) + noise_variance);
  }
}

}  // namespace

template <typename T>
absl::Status CovarianceMatrix(Context& context, const CovarianceParameters& parameters,
                              ConstMatrixView<double> x, double noise_variance, Triangle triangle,
                              MatrixView<T> out) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, x.rows));
  EGOSIEVE_RETURN_IF_ERROR(
      CheckOptions({{"noise_variance", noise_variance, IsNotNegative(noise_variance),
                     "be finite and at least 0"}}));
  const bool lower_only = triangle == Triangle::kLower;
  if (RunsOnHost<T>(context)) {
    reference::CovarianceBlock(parameters, x, x, lower_only, out);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(opencl::CovarianceBlock(context, parameters, x, x, lower_only, out));
  }
  AddNoise(noise_variance, out);
  return absl::OkStatus();
}

template <typename T>
absl::Status CrossCovariance(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z,
                             MatrixView<T> out) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("z", parameters, z));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, z.rows));
  if (RunsOnHost<T>(context)) {
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

template absl::Status CovarianceMatrix(Context&, const CovarianceParameters&,
                                       ConstMatrixView<double>, double, Triangle,
                                       MatrixView<float>);
template absl::Status CovarianceMatrix(Context&, const CovarianceParameters&,
                                       ConstMatrixView<double>, double, Triangle,
                                       MatrixView<double>);
template absl::Status CrossCovariance(Context&, const CovarianceParameters&,
                                      ConstMatrixView<double>, ConstMatrixView<double>,
                                      MatrixView<float>);
template absl::Status CrossCovariance(Context&, const CovarianceParameters&,
                                      ConstMatrixView<double>, ConstMatrixView<double>,
                                      MatrixView<double>);

}  // namespace egosieve::kernels
