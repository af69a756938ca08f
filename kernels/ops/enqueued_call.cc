#include "kernels/ops/enqueued_call.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels::opencl {
namespace {

void CL_CALLBACK GiveBackWhatWasUsed(cl_event, cl_int status, void* in_use) {
  const std::unique_ptr<CallInUse> ended(static_cast<CallInUse*>(in_use));
  if (status == CL_COMPLETE) ended->context->GiveBack(std::move(ended->workspace));
}

// Keeps the resources until `last` ends.
void KeepUntil(const cl::Event& last, std::unique_ptr<CallInUse> in_use) {
  if (clSetEventCallback(last(), CL_COMPLETE, GiveBackWhatWasUsed, in_use.get()) == CL_SUCCESS) {
    static_cast<void>(in_use.release());  // the callback owns it
  } else {
    last.wait();
  }
}

}  // namespace

absl::Status CheckDeviceArray(const Context& context, const char* name, cl_mem memory,
                              int64_t first, int64_t elements, int64_t bytes) {
  const int64_t most = std::numeric_limits<int64_t>::max() / bytes;
  EGOSIEVE_REQUIRE(InvalidArgument, first >= 0 && first <= most - elements,
                   "%s: first = %d; out of range", name, first);
  cl_context theirs = nullptr;
  size_t size = 0;
  EGOSIEVE_REQUIRE(
      InvalidArgument,
      memory != nullptr &&
          clGetMemObjectInfo(memory, CL_MEM_CONTEXT, sizeof(cl_context), &theirs, nullptr) ==
              CL_SUCCESS &&
          clGetMemObjectInfo(memory, CL_MEM_SIZE, sizeof size, &size, nullptr) == CL_SUCCESS,
      "%s is no OpenCL buffer", name);
  EGOSIEVE_REQUIRE(InvalidArgument, theirs == context.cl_context()(),
                   "%s belongs to another OpenCL context than the model", name);
  EGOSIEVE_REQUIRE(InvalidArgument, static_cast<int64_t>(size) / bytes >= first + elements,
                   "%s has %d bytes; %d elements of %d bytes are needed", name, size,
                   first + elements, bytes);
  return absl::OkStatus();
}

absl::Status CheckBufferMatrix(const Context& context, const char* name, const BufferMatrix& matrix,
                               int64_t columns, int64_t bytes) {
  const int64_t stride = matrix.stride == 0 ? columns : matrix.stride;
  EGOSIEVE_REQUIRE(
      InvalidArgument,
      matrix.rows >= 0 && stride >= columns &&
          matrix.rows <= std::numeric_limits<int64_t>::max() / bytes / std::max<int64_t>(stride, 1),
      "%s: rows = %d, stride = %d; out of range for a matrix of %d columns", name, matrix.rows,
      stride, columns);
  if (matrix.rows == 0 || columns == 0) return absl::OkStatus();
  return CheckDeviceArray(context, name, matrix.memory, matrix.first,
                          (matrix.rows - 1) * stride + columns, bytes);
}

absl::Status CheckDeviceCall(const Context& context, const DeviceCall& call) {
  cl_context theirs = nullptr;
  cl_device_id device = nullptr;
  EGOSIEVE_REQUIRE(InvalidArgument,
                   call.queue != nullptr &&
                       clGetCommandQueueInfo(call.queue, CL_QUEUE_CONTEXT, sizeof(cl_context),
                                             &theirs, nullptr) == CL_SUCCESS &&
                       clGetCommandQueueInfo(call.queue, CL_QUEUE_DEVICE, sizeof(cl_device_id),
                                             &device, nullptr) == CL_SUCCESS,
                   "queue is no OpenCL command queue");
  EGOSIEVE_REQUIRE(InvalidArgument,
                   theirs == context.cl_context()() && device == context.cl_device()(),
                   "queue belongs to another OpenCL context or device than the model");
  EGOSIEVE_REQUIRE(InvalidArgument, call.wait_count == 0 || call.wait != nullptr,
                   "wait is null, wait_count is not 0");
  for (uint32_t i = 0; i < call.wait_count; ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument,
                     call.wait[i] != nullptr &&
                         clGetEventInfo(call.wait[i], CL_EVENT_CONTEXT, sizeof(cl_context), &theirs,
                                        nullptr) == CL_SUCCESS &&
                         theirs == context.cl_context()(),
                     "wait[%d] is no event of the model's OpenCL context", i);
  }
  return absl::OkStatus();
}

absl::StatusOr<cl_event> EnqueueCall(
    const char* doing, const DeviceCall& call, std::unique_ptr<CallInUse> in_use,
    const std::function<void(const cl::CommandQueue&, std::vector<cl::Event>&)>& enqueue) {
  std::vector<cl::Event> last;
  const absl::Status status = CatchOpenClErrors(doing, [&] {
    for (uint32_t i = 0; i < call.wait_count; ++i) last.emplace_back(call.wait[i], true);
    const cl::CommandQueue queue(call.queue, /*retainObject=*/true);
    enqueue(queue, last);
    queue.flush();
  });
  const bool started = !last.empty() && (call.wait_count == 0 || last[0]() != call.wait[0]);
  cl_event event = nullptr;
  if (started) {
    if (status.ok()) clRetainEvent(event = last[0]());
    EGOSIEVE_RETURN_IF_ERROR(
        CatchOpenClErrors(doing, [&] { KeepUntil(last[0], std::move(in_use)); }));
  }
  EGOSIEVE_RETURN_IF_ERROR(status);
  return event;
}

void Mark(const cl::CommandQueue& queue, std::vector<cl::Event>& last) {
  cl::Event done;
  queue.enqueueMarkerWithWaitList(&last, &done);
  last = {done};
}

}  // namespace egosieve::kernels::opencl
