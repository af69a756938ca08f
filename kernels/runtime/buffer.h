// Device buffers for the caller's arrays, without copies if the device shares the host's memory.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <vector>

#include "kernels/base/aligned_array.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {

// All of these functions throw cl::Error: call them inside CatchOpenClErrors.

// A buffer of `bytes` at `data`, which must not change while the buffer is in use. bytes > 0.
inline cl::Buffer InputBuffer(const Context& context, const void* data, size_t bytes) {
  const cl_mem_flags placement =
      context.shares_host_memory() ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR;
  // The bindings need a mutable pointer, but a read-only buffer is never written.
  return cl::Buffer(context.cl_context(), CL_MEM_READ_ONLY | placement, bytes,
                    const_cast<void*>(data));
}

template <typename T>
cl::Buffer InputBuffer(const Context& context, const std::vector<T>& values) {
  return InputBuffer(context, values.data(), values.size() * sizeof(T));
}

template <typename T>
cl::Buffer InputBuffer(const Context& context, const AlignedArray<T>& values) {
  return InputBuffer(context, values.data(), values.size() * sizeof(T));
}

// A strided matrix as stored in memory: rows * stride elements minus the last row's padding.
template <typename T>
cl::Buffer InputBuffer(const Context& context, const MatrixView<T>& view) {
  return InputBuffer(context, view.data, ((view.rows - 1) * view.stride + view.cols) * sizeof(T));
}

// Elements of the output that a kernel does not write. kKept: they keep their values, at the cost
// of an upload to devices with their own memory. kPadding: the kernel writes the whole matrix, and
// the padding between rows is kept. kNone: there are no such elements.
enum class Unwritten { kKept, kPadding, kNone };

// The caller's matrix as a kernel's output.
template <typename T>
class OutputBuffer {
 public:
  OutputBuffer(const Context& context, const MatrixView<T>& view,
               Unwritten unwritten = Unwritten::kKept)
      : shared_(context.shares_host_memory()),
        view_(view),
        bytes_(((view.rows - 1) * view.stride + view.cols) * sizeof(T)),
        kept_(unwritten == Unwritten::kKept ||
              (unwritten == Unwritten::kPadding && view.stride != view.cols)),
        buffer_(context.cl_context(), CL_MEM_READ_WRITE | HostFlag(shared_, kept_), bytes_,
                shared_ || kept_ ? view.data : nullptr) {}

  const cl::Buffer& buffer() const { return buffer_; }

  // Makes the results visible to the host, and waits for them.
  void Finish(const cl::CommandQueue& queue) {
    if (shared_) {
      void* mapped = queue.enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ, 0, bytes_);
      queue.enqueueUnmapMemObject(buffer_, mapped);
    } else {
      queue.enqueueReadBuffer(buffer_, CL_TRUE, 0, bytes_, view_.data);
    }
    queue.finish();
  }

 private:
  static cl_mem_flags HostFlag(bool shared, bool kept) {
    if (shared) return CL_MEM_USE_HOST_PTR;
    return kept ? CL_MEM_COPY_HOST_PTR : 0;
  }

  bool shared_;
  MatrixView<T> view_;
  size_t bytes_;
  bool kept_;
  cl::Buffer buffer_;
};

// Waits for the queue's commands at the end of its scope, also after an exception. The commands use
// arrays of the caller, so declare it after all of these and before the first command.
class CommandsEnd {
 public:
  explicit CommandsEnd(const cl::CommandQueue& queue) : queue_(queue) {}
  CommandsEnd(const CommandsEnd&) = delete;
  CommandsEnd& operator=(const CommandsEnd&) = delete;
  ~CommandsEnd() { clFinish(queue_()); }  // fails if nothing runs any more

 private:
  cl::CommandQueue queue_;
};

// Sets arguments 0, 1, 2, ... of a kernel.
template <typename... Arguments>
void SetArguments(cl::Kernel& kernel, const Arguments&... arguments) {
  cl_uint index = 0;
  (kernel.setArg(index++, arguments), ...);
}

}  // namespace egosieve::kernels
