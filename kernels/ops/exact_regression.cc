#include "kernels/ops/exact_regression.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

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
using opencl::PreparedBlock;

absl::Status CheckNoisyPoints(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                              absl::Span<const double> variances) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_REQUIRE(InvalidArgument, x.rows >= 1 && x.rows <= std::numeric_limits<int32_t>::max(),
                   "regression needs points");
  EGOSIEVE_REQUIRE(InvalidArgument,
                   variances.empty() || static_cast<int64_t>(variances.size()) == x.rows,
                   "%d noise variances for %d points", variances.size(), x.rows);
  return absl::OkStatus();
}

absl::Status CheckTargets(ConstMatrixView<double> x, ConstMatrixView<double> y) {
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("y", y, x.rows, y.cols));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("y", y));
  EGOSIEVE_REQUIRE(InvalidArgument, y.cols >= 1, "regression needs at least one output");
  return absl::OkStatus();
}

std::vector<double> Download(const cl::CommandQueue& queue, const cl::Buffer& buffer,
                             int64_t count) {
  std::vector<double> values(count);
  queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(double), values.data());
  return values;
}

// Operations and resources for one computation on the device.
struct Tools {
  DeviceLinearAlgebra algebra;
  CovarianceKernels covariance;
};

// Calls work(queue, tools, points), which may throw cl::Error.
template <typename Work>
absl::Status OnDevice(Context& context, const CovarianceParameters& parameters,
                      ConstMatrixView<double> x, bool with_gradient, const char* doing,
                      const Work& work) {
  EGOSIEVE_REQUIRE(FailedPrecondition, !context.is_reference(),
                   "the reference has no device: open an OpenCL device");
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(doing));
  EGOSIEVE_ASSIGN_OR_RETURN(DeviceLinearAlgebra algebra,
                            DeviceLinearAlgebra::Create(context, *workspace));
  EGOSIEVE_ASSIGN_OR_RETURN(
      CovarianceKernels covariance,
      CovarianceKernels::Create(
          context, *workspace, parameters,
          CovarianceKernels::kBlock | (with_gradient ? CovarianceKernels::kGradient : 0)));
  Tools tools{std::move(algebra), std::move(covariance)};
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(doing, [&] {
    const CovariancePoints points(context, parameters, x, x);
    const CommandsEnd end(workspace->queue());
    work(workspace->queue(), tools, points.block());
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

// The noise variance of each of `count` points.
std::vector<double> Filled(absl::Span<const double> variances, int64_t count) {
  std::vector<double> noise(variances.begin(), variances.end());
  noise.resize(count, 0.0);
  return noise;
}

struct Factored {
  DeviceFactor factor;
  int64_t bad_row = -1;
};

// L of (1). Throws cl::Error.
Factored Factorize(const Context& context, const cl::CommandQueue& queue, Tools& tools,
                   const PreparedBlock& points, double noise_variance,
                   const std::vector<double>& variances) {
  const int64_t n = points.row_count;
  DeviceMatrix matrix = opencl::NewDeviceMatrix(context, n, n);
  tools.covariance.EnqueueBlock(queue, points, /*lower_only=*/true, matrix.buffer, 0, n);
  const DeviceMatrix of_points = tools.algebra.Upload({variances.data(), n, 1});
  DeviceMatrix floors = opencl::NewDeviceMatrix(context, n, 1);
  tools.algebra.AddNoise(matrix, noise_variance, of_points,
                         static_cast<double>(n) * std::numeric_limits<double>::epsilon(), floors);
  const cl::Buffer bad(context.cl_context(), CL_MEM_READ_WRITE, sizeof(cl_int));
  queue.enqueueFillBuffer(bad, cl_int{-1}, 0, sizeof(cl_int));
  Factored factored{tools.algebra.Factorize(std::move(matrix), floors, bad)};
  cl_int bad_row = -1;
  queue.enqueueReadBuffer(bad, CL_TRUE, 0, sizeof bad_row, &bad_row);
  factored.bad_row = bad_row;
  return factored;
}

// Throws cl::Error.
ExactRegression Regress(const Context& context, const cl::CommandQueue& queue, Tools& tools,
                        const PreparedBlock& points, ConstMatrixView<double> y,
                        double noise_variance, const std::vector<double>& variances,
                        bool with_gradient) {
  const int64_t n = points.row_count, k = y.cols;
  const auto [factor, bad_row] =
      Factorize(context, queue, tools, points, noise_variance, variances);
  ExactRegression result;
  result.bad_row = bad_row;
  if (bad_row >= 0) return result;

  DeviceLinearAlgebra& algebra = tools.algebra;
  CovarianceKernels& covariance = tools.covariance;
  DeviceMatrix values = opencl::NewDeviceMatrix(context, n, 1);  // a diagonal
  algebra.GetDiagonal(factor.lower, values);
  DeviceMatrix alpha = algebra.Upload(y);
  algebra.SolveLower(factor, alpha);
  algebra.SolveLowerTransposed(factor, alpha);
  result.alpha = Download(queue, alpha.buffer, n * k);
  for (const double pivot : Download(queue, values.buffer, n)) {
    result.half_log_determinant += std::log(pivot);  // (2)
  }
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t c = 0; c < k; ++c) result.fit += y(i, c) * result.alpha[i * k + c];
  }
  if (!with_gradient) return result;

  const DeviceMatrix inverse = algebra.InvertLower(factor);
  DeviceMatrix weights = factor.lower;  // the same memory: the factor is no longer needed
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
  EGOSIEVE_RETURN_IF_ERROR(CheckNoisyPoints(parameters, x, variances));
  EGOSIEVE_RETURN_IF_ERROR(CheckTargets(x, y));
  const std::vector<double> noise = Filled(variances, x.rows);
  ExactRegression result;
  EGOSIEVE_RETURN_IF_ERROR(OnDevice(
      context, parameters, x, with_gradient, "regressing on the device",
      [&](const cl::CommandQueue& queue, Tools& tools, const PreparedBlock& points) {
        result = Regress(context, queue, tools, points, y, noise_variance, noise, with_gradient);
      }));
  return result;
}

absl::StatusOr<int64_t> FactorizeOnDevice(Context& context, const CovarianceParameters& parameters,
                                          ConstMatrixView<double> x, double noise_variance,
                                          absl::Span<const double> variances,
                                          MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(CheckNoisyPoints(parameters, x, variances));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, x.rows));
  const std::vector<double> noise = Filled(variances, x.rows);
  int64_t bad_row = -1;
  EGOSIEVE_RETURN_IF_ERROR(OnDevice(
      context, parameters, x, /*with_gradient=*/false, "factorising on the device",
      [&](const cl::CommandQueue& queue, Tools& tools, const PreparedBlock& points) {
        const Factored factored = Factorize(context, queue, tools, points, noise_variance, noise);
        bad_row = factored.bad_row;
        if (bad_row < 0) tools.algebra.DownloadLower(factored.factor.lower, out);
      }));
  return bad_row;
}

}  // namespace egosieve::kernels
