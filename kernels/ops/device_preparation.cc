#include "kernels/ops/device_preparation.h"

#include <type_traits>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/runtime/buffer.h"

namespace egosieve::kernels::opencl {
namespace {

// Points per group, always the same, because PoCL compiles a kernel anew for every group size.
constexpr int64_t kPreparationGroup = 64;

std::string CodeOf(const CovarianceParameters& parameters) {
  DeviceCodeRequest request;
  request.dimension = parameters.input_dimension();
  return absl::StrCat(
      "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n#pragma OPENCL FP_CONTRACT OFF\n",
      "#define DIMENSION ", request.dimension, "\n#define POINT ", PreparedWidth(parameters),
      "\n#define SCALES ", parameters.scales.size(), "\n",
      parameters.function.description().PreparationCode(request));
}

}  // namespace

DevicePreparation::DevicePreparation(const Context& context, const CovarianceParameters& parameters,
                                     const PointPreparation& preparation)
    : code_(CodeOf(parameters)), scales_and_centre_(parameters.scales) {
  const std::vector<double>& centre = preparation.centre();
  scales_and_centre_.insert(scales_and_centre_.end(), centre.begin(), centre.end());
  buffer_ = InputBuffer(context, scales_and_centre_);
}

template <typename T>
absl::StatusOr<cl::Kernel> DevicePreparation::Kernel(const Context& context,
                                                     Workspace& workspace) const {
  EGOSIEVE_REQUIRE(FailedPrecondition, context.info().float64,
                   "%s has no float64, in which points are prepared: hand them over in the host's "
                   "memory",
                   context.info().name);
  const char* real = std::is_same_v<T, double> ? " -DREAL_IS_DOUBLE" : "";
  return workspace.Kernel("prepare_points.cl", absl::StrCat("-cl-std=CL1.2 -DVEC=1", real),
                          "prepare_points", code_);
}

cl::Event DevicePreparation::Enqueue(cl::Kernel& kernel, const cl::CommandQueue& queue,
                                     const PointsAt& points, const PreparedAt& out,
                                     const std::vector<cl::Event>& after) const {
  SetArguments(kernel, points.memory, cl_long{points.first}, cl_long{points.stride},
               cl_long{points.count}, cl_long{out.padded_count}, buffer_, out.buffer,
               cl_long{out.component_step}, cl_long{out.point_step});
  cl::Event done;
  const int64_t groups = (out.padded_count + kPreparationGroup - 1) / kPreparationGroup;
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(groups * kPreparationGroup),
                             cl::NDRange(kPreparationGroup), &after, &done);
  return done;
}

template absl::StatusOr<cl::Kernel> DevicePreparation::Kernel<float>(const Context&,
                                                                     Workspace&) const;
template absl::StatusOr<cl::Kernel> DevicePreparation::Kernel<double>(const Context&,
                                                                      Workspace&) const;

}  // namespace egosieve::kernels::opencl
