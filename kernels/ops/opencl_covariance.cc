#include "kernels/ops/opencl_covariance.h"

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/device_preparation.h"
#include "kernels/ops/enqueued_call.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace opencl {
namespace {

// Rows per work-group: enough to share the loads of the columns, few enough to balance triangles.
constexpr int64_t kRows = 4;

int64_t Groups(int64_t rows) { return (rows + kRows - 1) / kRows; }

}  // namespace

CovariancePoints::CovariancePoints(const Context& context, const CovarianceParameters& parameters,
                                   ConstMatrixView<double> x, ConstMatrixView<double> z) {
  const PointPreparation preparation(parameters);
  rows_ = PrepareRows<double, double>(preparation, x);
  columns_ = PrepareColumns<double, double>(preparation, z, Lanes<double>(context));
  block_ = {InputBuffer(context, rows_), InputBuffer(context, columns_.values), x.rows, z.rows,
            columns_.stride};
}

absl::StatusOr<CovarianceKernels> CovarianceKernels::Create(Context& context, Workspace& workspace,
                                                            const CovarianceParameters& parameters,
                                                            int what) {
  CovarianceKernels kernels;
  kernels.work_group_ = SideBySide(context);
  kernels.scales_ = static_cast<int64_t>(parameters.scales.size());
  kernels.signal_variance_ = parameters.signal_stddev * parameters.signal_stddev;
  const std::string options = absl::StrCat(BuildOptions<double>(context), " -DROWS=", kRows,
                                           " -DWORK_GROUP=", kernels.work_group_);
  const std::string& code = CovarianceCode(parameters);
  if ((what & kBlock) != 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(kernels.block_,
                              workspace.Kernel("covariance.cl", options, "covariance_block", code));
  }
  if ((what & kGradient) != 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(kernels.gradient_, workspace.Kernel("covariance_gradient.cl", options,
                                                                  "covariance_gradient", code));
  }
  return kernels;
}

void CovarianceKernels::EnqueueBlock(const cl::CommandQueue& queue, const PreparedBlock& points,
                                     bool lower_only, const cl::Buffer& out, int64_t out_first,
                                     int64_t out_stride, const std::vector<cl::Event>* after,
                                     cl::Event* done) {
  SetArguments(block_, points.rows, points.columns, cl_long{points.row_count},
               cl_long{points.column_count}, cl_long{points.column_stride}, signal_variance_,
               cl_int{lower_only}, out, cl_long{out_first}, cl_long{out_stride});
  queue.enqueueNDRangeKernel(block_, cl::NullRange,
                             cl::NDRange(Groups(points.row_count) * work_group_),
                             cl::NDRange(work_group_), after, done);
}

void CovarianceKernels::EnqueueGradient(const cl::CommandQueue& queue, const PreparedBlock& points,
                                        bool lower_only, const cl::Buffer& weights,
                                        int64_t weight_stride, const cl::Buffer& out) {
  SetArguments(gradient_, points.rows, points.columns, cl_long{points.row_count},
               cl_long{points.column_count}, cl_long{points.column_stride}, cl_int{lower_only},
               weights, cl_long{weight_stride}, out);
  queue.enqueueNDRangeKernel(gradient_, cl::NullRange,
                             cl::NDRange(Groups(points.row_count) * work_group_),
                             cl::NDRange(work_group_));
}

int64_t CovarianceKernels::GradientRows(int64_t rows) { return Groups(rows); }

std::vector<double> CovarianceKernels::GradientOf(const std::vector<double>& partial_sums) const {
  std::vector<double> gradient(GradientColumns(), 0.0);
  for (size_t i = 0; i < partial_sums.size(); ++i) {
    gradient[i % gradient.size()] += partial_sums[i];
  }
  for (double& value : gradient) value *= signal_variance_;
  return gradient;
}

absl::Status CovarianceBlock(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z, bool lower_only,
                             MatrixView<double> out) {
  if (out.empty()) return absl::OkStatus();
  constexpr char kDoing[] = "computing a covariance matrix";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(
      CovarianceKernels kernels,
      CovarianceKernels::Create(context, *workspace, parameters, CovarianceKernels::kBlock));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const CovariancePoints points(context, parameters, x, z);
    OutputBuffer<double> result(context, out, lower_only ? Unwritten::kKept : Unwritten::kPadding);
    const CommandsEnd end(workspace->queue());
    kernels.EnqueueBlock(workspace->queue(), points.block(), lower_only, result.buffer(), 0,
                         out.stride);
    result.Finish(workspace->queue());
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> z,
                                                       ConstMatrixView<double> w, bool lower_only) {
  if (x.rows == 0 || z.rows == 0) return std::vector<double>(parameters.scales.size() + 1, 0.0);
  constexpr char kDoing[] = "computing a covariance gradient";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(
      CovarianceKernels kernels,
      CovarianceKernels::Create(context, *workspace, parameters, CovarianceKernels::kGradient));
  const int64_t rows = CovarianceKernels::GradientRows(x.rows);
  std::vector<double> partial_sums(rows * kernels.GradientColumns());
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const CovariancePoints points(context, parameters, x, z);
    const cl::Buffer weights = InputBuffer(context, w);
    OutputBuffer<double> result(
        context, MatrixView<double>(partial_sums.data(), rows, kernels.GradientColumns()),
        Unwritten::kNone);
    const CommandsEnd end(workspace->queue());
    kernels.EnqueueGradient(workspace->queue(), points.block(), lower_only, weights, w.stride,
                            result.buffer());
    result.Finish(workspace->queue());
  }));
  context.GiveBack(std::move(workspace));
  return kernels.GradientOf(partial_sums);
}

}  // namespace opencl

absl::StatusOr<cl_event> EnqueueCrossCovariance(std::shared_ptr<Context> context,
                                                const CovarianceParameters& parameters,
                                                const BufferMatrix& x, const BufferMatrix& z,
                                                const BufferMatrix& k, const DeviceCall& call) {
  using namespace opencl;
  constexpr char kDoing[] = "enqueuing a covariance matrix";
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_REQUIRE(FailedPrecondition, !context->is_reference(),
                   "the device \"reference\" has no OpenCL context");
  const int64_t dimension = parameters.input_dimension();
  EGOSIEVE_RETURN_IF_ERROR(CheckDeviceCall(*context, call));
  EGOSIEVE_RETURN_IF_ERROR(CheckBufferMatrix(*context, "x", x, dimension, sizeof(double)));
  EGOSIEVE_RETURN_IF_ERROR(CheckBufferMatrix(*context, "z", z, dimension, sizeof(double)));
  EGOSIEVE_RETURN_IF_ERROR(CheckBufferMatrix(*context, "k", k, z.rows, sizeof(double)));
  EGOSIEVE_REQUIRE(InvalidArgument, k.rows == x.rows, "k has %d rows; x has %d", k.rows, x.rows);
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context->Borrow(kDoing));
  std::shared_ptr<const DevicePreparation> preparation;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    preparation = std::make_shared<const DevicePreparation>(*context, parameters,
                                                            PointPreparation(parameters));
  }));
  EGOSIEVE_ASSIGN_OR_RETURN(cl::Kernel prepare, preparation->Kernel<double>(*context, *workspace));
  EGOSIEVE_ASSIGN_OR_RETURN(
      CovarianceKernels kernels,
      CovarianceKernels::Create(*context, *workspace, parameters, CovarianceKernels::kBlock));
  const int64_t lanes = Lanes<double>(*context), width = PreparedWidth(parameters);
  auto in_use =
      std::make_unique<CallInUse>(CallInUse{context, std::move(workspace), {preparation}});
  return EnqueueCall(
      kDoing, call, std::move(in_use),
      [&](const cl::CommandQueue& queue, std::vector<cl::Event>& last) {
        if (x.rows == 0 || z.rows == 0) return Mark(queue, last);
        const auto points_of = [&](const BufferMatrix& m) {
          return PointsAt{cl::Buffer(m.memory, /*retainObject=*/true), m.first,
                          m.stride == 0 ? dimension : m.stride, m.rows};
        };
        const auto room = [&](int64_t points) {
          return cl::Buffer(context->cl_context(), CL_MEM_READ_WRITE,
                            points * width * sizeof(double));
        };
        const int64_t padded = (z.rows + lanes - 1) / lanes * lanes;
        const PreparedBlock block = {room(x.rows), room(padded), x.rows, z.rows, padded};
        last = {preparation->Enqueue(prepare, queue, points_of(x), {block.rows, 1, width, x.rows},
                                     last)};
        last = {preparation->Enqueue(prepare, queue, points_of(z),
                                     {block.columns, padded, 1, padded}, last)};
        cl::Event done;
        kernels.EnqueueBlock(queue, block, /*lower_only=*/false,
                             cl::Buffer(k.memory, /*retainObject=*/true), k.first,
                             k.stride == 0 ? z.rows : k.stride, &last, &done);
        last = {done};
      });
}

}  // namespace egosieve::kernels
