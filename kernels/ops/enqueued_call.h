// Commands that are enqueued on the caller's queue without waiting; checks of the caller's OpenCL
// handles, with clearer errors than the driver's.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/ops/device_call.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// InvalidArgument unless the queue and all events belong to this context, and the queue to its
// device.
absl::Status CheckDeviceCall(const Context& context, const DeviceCall& call);

// InvalidArgument, naming it, unless `elements` values of `bytes` each, from the element `first` on,
// lie in a buffer of this context.
absl::Status CheckDeviceArray(const Context& context, const char* name, cl_mem memory,
                              int64_t first, int64_t elements, int64_t bytes);
// The same of a matrix of this many columns.
absl::Status CheckBufferMatrix(const Context& context, const char* name, const BufferMatrix& matrix,
                               int64_t columns, int64_t bytes);

// What the commands of a call need until the last has ended; then the workspace is given back.
struct CallInUse {
  std::shared_ptr<Context> context;
  std::unique_ptr<Workspace> workspace;
  std::vector<std::shared_ptr<const void>> others;
};

// enqueue(queue, last): its first commands wait for the events in `last`, which holds the event of
// its last command afterwards; may throw cl::Error. The call must be checked. Returns that event,
// which the caller of the library releases.
absl::StatusOr<cl_event> EnqueueCall(
    const char* doing, const DeviceCall& call, std::unique_ptr<CallInUse> in_use,
    const std::function<void(const cl::CommandQueue& queue, std::vector<cl::Event>& last)>&
        enqueue);

// Ends a call that has no other command.
void Mark(const cl::CommandQueue& queue, std::vector<cl::Event>& last);

}  // namespace egosieve::kernels::opencl
