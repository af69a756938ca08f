#include "kernels/ops/device_call_checks.h"

#include <limits>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels::opencl {
namespace {

// Checks an array of `elements` values of 4 bytes, starting at `first`.
absl::Status CheckArray(const Context& context, const char* name, cl_mem memory, int64_t first,
                        int64_t elements) {
  constexpr int64_t kElementBytes = 4;
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max() / kElementBytes;
  if (first < 0 || first > kMost - elements) {
    return absl::InvalidArgumentError(absl::StrFormat("%s: first = %d; out of range", name, first));
  }
  cl_context theirs = nullptr;
  size_t bytes = 0;
  if (memory == nullptr ||
      clGetMemObjectInfo(memory, CL_MEM_CONTEXT, sizeof(cl_context), &theirs, nullptr) !=
          CL_SUCCESS ||
      clGetMemObjectInfo(memory, CL_MEM_SIZE, sizeof bytes, &bytes, nullptr) != CL_SUCCESS) {
    return absl::InvalidArgumentError(absl::StrFormat("%s is no OpenCL buffer", name));
  }
  if (theirs != context.cl_context()()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s belongs to another OpenCL context than the model", name));
  }
  if (static_cast<int64_t>(bytes) / kElementBytes < first + elements) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s has %d bytes; %d elements of 4 bytes are needed", name, bytes, first + elements));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckDeviceCall(const Context& context, const DeviceCall& call) {
  cl_context theirs = nullptr;
  cl_device_id device = nullptr;
  if (call.queue == nullptr ||
      clGetCommandQueueInfo(call.queue, CL_QUEUE_CONTEXT, sizeof(cl_context), &theirs, nullptr) !=
          CL_SUCCESS ||
      clGetCommandQueueInfo(call.queue, CL_QUEUE_DEVICE, sizeof(cl_device_id), &device, nullptr) !=
          CL_SUCCESS) {
    return absl::InvalidArgumentError("queue is no OpenCL command queue");
  }
  if (theirs != context.cl_context()() || device != context.cl_device()()) {
    return absl::InvalidArgumentError(
        "queue belongs to another OpenCL context or device than the model");
  }
  if (call.wait_count > 0 && call.wait == nullptr) {
    return absl::InvalidArgumentError("wait is null, wait_count is not 0");
  }
  for (uint32_t i = 0; i < call.wait_count; ++i) {
    if (call.wait[i] == nullptr ||
        clGetEventInfo(call.wait[i], CL_EVENT_CONTEXT, sizeof(cl_context), &theirs, nullptr) !=
            CL_SUCCESS ||
        theirs != context.cl_context()()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("wait[%d] is no event of the model's OpenCL context", i));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckDeviceArrays(const Context& context, int64_t dimension,
                               const DeviceQueries& queries, const DeviceOutputs& outputs) {
  constexpr int64_t kMostQueries = int64_t{1} << 40;
  constexpr int64_t kMostStride = int64_t{1} << 20;
  const int64_t stride = queries.stride == 0 ? dimension : queries.stride;
  if (queries.count < 0 || queries.count > kMostQueries || stride < dimension ||
      stride > kMostStride) {
    return absl::InvalidArgumentError(
        absl::StrFormat("queries: count = %d, stride = %d; the model has %d inputs", queries.count,
                        stride, dimension));
  }
  if (queries.count > 0) {
    EGOSIEVE_RETURN_IF_ERROR(CheckArray(context, "queries", queries.memory, queries.first,
                                        (queries.count - 1) * stride + dimension));
  }
  struct Named {
    const char* name;
    const DeviceOutput& output;
    int64_t elements;
  };
  for (const Named& one : {Named{"mean", outputs.mean, queries.count},
                           Named{"variance", outputs.variance, queries.count},
                           Named{"probability", outputs.probability, queries.count},
                           Named{"clamped", outputs.clamped, 1}}) {
    if (one.output.memory == nullptr) continue;
    EGOSIEVE_RETURN_IF_ERROR(
        CheckArray(context, one.name, one.output.memory, one.output.first, one.elements));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::kernels::opencl
