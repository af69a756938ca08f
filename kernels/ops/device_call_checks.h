// Checks of the caller's OpenCL handles, with clearer errors than the driver's.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// InvalidArgument unless the queue and all events belong to this context, and the queue to its
// device.
absl::Status CheckDeviceCall(const Context& context, const DeviceCall& call);

// InvalidArgument, naming the array, unless each belongs to this context and is large enough.
absl::Status CheckDeviceArrays(const Context& context, int64_t dimension,
                               const DeviceQueries& queries, const DeviceOutputs& outputs);

}  // namespace egosieve::kernels::opencl
