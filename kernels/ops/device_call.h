// Commands on the caller's OpenCL queue, from and to the caller's buffers.
#pragma once

#include <cstdint>

#include "kernels/runtime/opencl_handles.h"

namespace egosieve::kernels {

// The queue and events of a call's commands.
struct DeviceCall {
  cl_command_queue queue = nullptr;  // of the same context and device; in order or not
  const cl_event* wait = nullptr;    // wait_count events that the commands wait for
  uint32_t wait_count = 0;
};

// A matrix in a buffer: element (i, j) is at first + i stride + j.
struct BufferMatrix {
  cl_mem memory = nullptr;
  int64_t rows = 0;
  int64_t first = 0;
  int64_t stride = 0;  // at least the number of columns; 0: that number
};

}  // namespace egosieve::kernels
