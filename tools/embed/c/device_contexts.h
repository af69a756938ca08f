// One context per device, shared by all objects on it, so that programs are compiled once.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"

namespace egosieve::embed {

// device: as in the C interface's options; null counts as empty. The context keeps its programs as
// long as the process lives, and its queues and scratch memory as long as any object uses it. It is
// opened anew if no object uses it and it gives no more queues. FailedPrecondition in a process
// that was forked from one that had used it.
absl::StatusOr<std::shared_ptr<kernels::Context>> ContextOf(const char* device);

// A context on the caller's OpenCL context and device; a null device is the context's first
// (kernels/runtime/opencl_context.h). It lives as long as any object uses it, so that the caller's
// is released then.
absl::StatusOr<std::shared_ptr<kernels::Context>> ContextOn(void* opencl_context,
                                                            void* opencl_device);

}  // namespace egosieve::embed
