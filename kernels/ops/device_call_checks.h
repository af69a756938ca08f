// Checks of the caller's OpenCL handles: the driver would say less.
#ifndef EGOSIEVE_KERNELS_OPS_DEVICE_CALL_CHECKS_H_
#define EGOSIEVE_KERNELS_OPS_DEVICE_CALL_CHECKS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// InvalidArgument unless the queue and every event are of this context, the queue of its device.
absl::Status CheckDeviceCall(const Context& context, const DeviceCall& call);

// InvalidArgument, naming the array, unless each is of this context and holds what it must.
absl::Status CheckDeviceArrays(const Context& context, int64_t dimension,
                               const DeviceQueries& queries, const DeviceOutputs& outputs);

}  // namespace egosieve::kernels::opencl

#endif  // EGOSIEVE_KERNELS_OPS_DEVICE_CALL_CHECKS_H_
