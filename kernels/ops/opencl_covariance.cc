#include "kernels/ops/opencl_covariance.h"

#include <type_traits>

#include "kernels/base/status_macros.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels::opencl {
namespace {

// Rows a work-item computes: enough to share the loads of the columns, few enough to balance
// triangles.
constexpr int kRows = 4;

int64_t WorkItems(int64_t rows) { return (rows + kRows - 1) / kRows; }

}  // namespace

template <typename T>
absl::Status CovarianceBlock(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z, bool lower_only,
                             MatrixView<T> out) {
  if (out.empty()) return absl::OkStatus();
  const std::string options = BuildOptions<T>(context) + " -DROWS=" + std::to_string(kRows);
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      context.Kernel("covariance.cl", options, "covariance_block", CovarianceCode(parameters)));
  return CatchOpenClErrors("computing a covariance matrix", [&] {
    const PointPreparation preparation = std::is_same_v<T, float>
                                             ? PointPreparation(parameters, CentreOf(x))
                                             : PointPreparation(parameters);
    const std::vector<T> rows = PrepareRows<double, T>(preparation, x);
    const PreparedColumns<T> columns = PrepareColumns<double, T>(preparation, z, Lanes<T>(context));
    const cl::Buffer row_buffer = InputBuffer(context, rows);
    const cl::Buffer column_buffer = InputBuffer(context, columns.values);
    OutputBuffer<T> result(context, out);
    const T signal_variance = static_cast<T>(parameters.signal_stddev * parameters.signal_stddev);
    SetArguments(kernel, row_buffer, column_buffer, cl_long{x.rows}, cl_long{z.rows},
                 cl_long{columns.stride}, signal_variance, cl_int{lower_only}, result.buffer(),
                 cl_long{out.stride});
    const cl::CommandQueue queue = context.NewQueue();
    const CommandsEnd end(queue);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(WorkItems(x.rows)),
                               cl::NDRange(1));
    result.Finish(queue);
  });
}

template absl::Status CovarianceBlock(Context&, const CovarianceParameters&,
                                      ConstMatrixView<double>, ConstMatrixView<double>, bool,
                                      MatrixView<float>);
template absl::Status CovarianceBlock(Context&, const CovarianceParameters&,
                                      ConstMatrixView<double>, ConstMatrixView<double>, bool,
                                      MatrixView<double>);

absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> z,
                                                       ConstMatrixView<double> w, bool lower_only) {
  const int64_t count = static_cast<int64_t>(parameters.scales.size()) + 1;
  std::vector<double> gradient(count, 0.0);
  if (x.rows == 0 || z.rows == 0) return gradient;
  const std::string options = BuildOptions<double>(context) + " -DROWS=" + std::to_string(kRows);
  EGOSIEVE_ASSIGN_OR_RETURN(cl::Kernel kernel,
                            context.Kernel("covariance_gradient.cl", options, "covariance_gradient",
                                           CovarianceCode(parameters)));
  std::vector<double> partial_sums(WorkItems(x.rows) * count);
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("computing a covariance gradient", [&] {
    const PointPreparation preparation(parameters);
    const std::vector<double> rows = PrepareRows<double, double>(preparation, x);
    const PreparedColumns<double> columns =
        PrepareColumns<double, double>(preparation, z, Lanes<double>(context));
    const cl::Buffer row_buffer = InputBuffer(context, rows);
    const cl::Buffer column_buffer = InputBuffer(context, columns.values);
    const cl::Buffer weight_buffer = InputBuffer(context, w);
    OutputBuffer<double> result(context,
                                MatrixView<double>(partial_sums.data(), WorkItems(x.rows), count));
    SetArguments(kernel, row_buffer, column_buffer, cl_long{x.rows}, cl_long{z.rows},
                 cl_long{columns.stride}, cl_int{lower_only}, weight_buffer, cl_long{w.stride},
                 result.buffer());
    const cl::CommandQueue queue = context.NewQueue();
    const CommandsEnd end(queue);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(WorkItems(x.rows)),
                               cl::NDRange(1));
    result.Finish(queue);
  }));
  // In order of rows, so that the sum is the same whatever ran where.
  for (size_t i = 0; i < partial_sums.size(); ++i) {
    gradient[i % count] += partial_sums[i];
  }
  for (double& value : gradient) {
    value *= parameters.signal_stddev * parameters.signal_stddev;
  }
  return gradient;
}

}  // namespace egosieve::kernels::opencl
