#include "kernels/runtime/buffer.h"

namespace egosieve::kernels {

cl::Buffer InputBuffer(const Context& context, const void* data, size_t bytes) {
  const cl_mem_flags placement =
      context.shares_host_memory() ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR;
  // The bindings need a mutable pointer, but a read-only buffer is never written.
  return cl::Buffer(context.cl_context(), CL_MEM_READ_ONLY | placement, bytes,
                    const_cast<void*>(data));
}

}  // namespace egosieve::kernels
