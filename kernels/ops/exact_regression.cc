#include "kernels/ops/exact_regression.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
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

absl::Status CheckProblem(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                          ConstMatrixView<double> y, double noise_variance,
                          absl::Span<const double> variances) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("x", x, x.rows, parameters.input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("x", x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("y", y, x.rows, y.cols));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("y", y));
  if (x.rows < 1 || x.rows > std::numeric_limits<int32_t>::max() || y.cols < 1) {
    return absl::InvalidArgumentError("regression needs points and at least one output");
  }
  if (!variances.empty() && static_cast<int64_t>(variances.size()) != x.rows) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d noise variances for %d points", variances.size(), x.rows));
  }
  if (!(noise_variance >= 0.0) || std::isinf(noise_variance)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("noise_variance = %g; it must be finite and at least 0", noise_variance));
  }
  for (const double value : variances) {
    if (!(value >= 0.0) || std::isinf(value)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("a noise variance of %g; it must be finite and at least 0", value));
    }
  }
  return absl::OkStatus();
}

// The values, packed, in the device's memory.
DeviceMatrix Upload(const Context& context, const cl::CommandQueue& queue,
                    const std::vector<double>& values, int64_t columns) {
  const int64_t rows = static_cast<int64_t>(values.size()) / columns;
  DeviceMatrix matrix = opencl::NewDeviceMatrix(context, rows, columns);
  queue.enqueueWriteBuffer(matrix.buffer, CL_TRUE, 0, values.size() * sizeof(double),
                           values.data());
  return matrix;
}

std::vector<double> Download(const cl::CommandQueue& queue, const cl::Buffer& buffer,
                             int64_t count) {
  std::vector<double> values(count);
  queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(double), values.data());
  return values;
}

// Throws cl::Error.
ExactRegression Regress(const Context& context, const cl::CommandQueue& queue,
                        DeviceLinearAlgebra& algebra, CovarianceKernels& covariance,
                        const CovariancePoints<double>& points, ConstMatrixView<double> y,
                        double noise_variance, const std::vector<double>& variances,
                        bool with_gradient) {
  const int64_t n = points.row_count(), k = y.cols;
  std::vector<double> targets;
  for (int64_t i = 0; i < n; ++i) targets.insert(targets.end(), y.row(i), y.row(i) + k);
  DeviceMatrix matrix = opencl::NewDeviceMatrix(context, n, n);
  covariance.EnqueueBlock(queue, points, /*lower_only=*/true, matrix.buffer, n);
  const DeviceMatrix of_points = Upload(context, queue, variances, 1);
  DeviceMatrix values = opencl::NewDeviceMatrix(context, n, 1);  // floors, then a diagonal
  algebra.AddNoise(matrix, noise_variance, of_points,
                   static_cast<double>(n) * std::numeric_limits<double>::epsilon(), values);
  const cl::Buffer bad(context.cl_context(), CL_MEM_READ_WRITE, sizeof(cl_int));
  queue.enqueueFillBuffer(bad, cl_int{-1}, 0, sizeof(cl_int));
  const DeviceFactor factor = algebra.Factorize(std::move(matrix), values, bad);
  cl_int bad_row = -1;
  queue.enqueueReadBuffer(bad, CL_TRUE, 0, sizeof bad_row, &bad_row);
  ExactRegression result;
  result.bad_row = bad_row;
  if (bad_row >= 0) return result;

  algebra.GetDiagonal(factor.lower, values);
  DeviceMatrix alpha = Upload(context, queue, targets, k);
  algebra.SolveLower(factor, alpha);
  algebra.SolveLowerTransposed(factor, alpha);
  result.alpha = Download(queue, alpha.buffer, n * k);
  for (const double pivot : Download(queue, values.buffer, n)) {
    result.half_log_determinant += std::log(pivot);  // (2)
  }
  for (int64_t i = 0; i < n * k; ++i) result.fit += targets[i] * result.alpha[i];
  if (!with_gradient) return result;

  const DeviceMatrix inverse = algebra.InvertLower(factor);
  DeviceMatrix weights = factor.lower;  // the same memory: the factor is not needed any more
  algebra.MultiplyInverse(inverse, weights);
  algebra.LikelihoodWeights(alpha, weights);
  algebra.GetDiagonal(weights, values);
  const int64_t sums = CovarianceKernels::GradientRows(n) * covariance.GradientColumns();
  const cl::Buffer partial_sums(context.cl_context(), CL_MEM_READ_WRITE, sums * sizeof(double));
  covariance.EnqueueGradient(queue, points, /*lower_only=*/true, weights.buffer, n, partial_sums);
  result.gradient = covariance.GradientOf(Download(queue, partial_sums, sums));  // (3)
  for (const double weight : Download(queue, values.buffer, n)) result.trace += weight;
  return result;
}

}  // namespace

bool RegressesOnDevice(const Context& context) {
  return !context.is_reference() && context.info().float64 && !context.shares_host_memory();
}

absl::StatusOr<ExactRegression> RegressOnDevice(Context& context,
                                                const CovarianceParameters& parameters,
                                                ConstMatrixView<double> x,
                                                ConstMatrixView<double> y, double noise_variance,
                                                absl::Span<const double> variances,
                                                bool with_gradient) {
  EGOSIEVE_RETURN_IF_ERROR(CheckProblem(parameters, x, y, noise_variance, variances));
  if (context.is_reference()) {
    return absl::FailedPreconditionError("the reference has no device: open an OpenCL device");
  }
  constexpr char kDoing[] = "regressing on the device";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(DeviceLinearAlgebra algebra,
                            DeviceLinearAlgebra::Create(context, *workspace));
  EGOSIEVE_ASSIGN_OR_RETURN(
      CovarianceKernels covariance,
      CovarianceKernels::Create<double>(
          context, *workspace, parameters,
          CovarianceKernels::kBlock | (with_gradient ? CovarianceKernels::kGradient : 0)));
  std::vector<double> noise(variances.begin(), variances.end());
  noise.resize(x.rows, 0.0);
  ExactRegression result;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const CovariancePoints<double> points(context, parameters, x, x);
    const CommandsEnd end(workspace->queue());
    result = Regress(context, workspace->queue(), algebra, covariance, points, y, noise_variance,
                     noise, with_gradient);
  }));
  context.GiveBack(std::move(workspace));
  return result;
}

}  // namespace egosieve::kernels
