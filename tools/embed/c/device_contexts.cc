#include "tools/embed/c/device_contexts.h"

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "kernels/base/status_macros.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::embed {
namespace {

using SharedContext = std::shared_ptr<kernels::Context>;
using WeakContext = std::weak_ptr<kernels::Context>;

struct KeptContext {
  SharedContext context;
  WeakContext in_use;  // what the present users share
};

std::mutex& Mutex() {
  static std::mutex* mutex = new std::mutex;
  return *mutex;
}

// For users, of whom the last frees the queues and the device memory that their calls left. A
// forked child leaves them to its parent.
SharedContext ForUsers(const SharedContext& kept) {
  return SharedContext(kept.get(), [kept](kernels::Context* context) {
    if (context->is_reference() || kernels::CheckNotForked().ok()) context->ReleaseIdle();
  });
}

// Whether operations can begin: after some failures of a device its contexts give no more queues.
bool HasQueues(kernels::Context& context) {
  if (context.is_reference()) return true;
  auto workspace = context.Borrow("using a context again");
  if (!workspace.ok()) return false;
  context.GiveBack(*std::move(workspace));
  return true;
}

}  // namespace

absl::StatusOr<SharedContext> ContextOf(const char* device) {
  // Never destroyed: when a process ends, drivers may be gone before static objects are.
  static auto* contexts = new std::map<std::string, KeptContext>;
  kernels::ContextOptions options;
  if (device != nullptr) options.device = device;
  if (const char* environment = std::getenv("EGOSIEVE_DEVICE");
      options.device.empty() && environment != nullptr) {
    options.device = environment;
  }
  const std::lock_guard lock(Mutex());
  KeptContext& kept = (*contexts)[options.device];
  if (kept.context != nullptr && !kept.context->is_reference()) {
    EGOSIEVE_RETURN_IF_ERROR(kernels::CheckNotForked());
  }
  if (SharedContext context = kept.in_use.lock()) return context;
  if (kept.context == nullptr || !HasQueues(*kept.context)) {
    EGOSIEVE_ASSIGN_OR_RETURN(kept.context, kernels::OpenContext(options));
  }
  SharedContext context = ForUsers(kept.context);
  kept.in_use = context;
  return context;
}

absl::StatusOr<SharedContext> ContextOn(void* opencl_context, void* opencl_device) {
  // The device is null where the caller's was. A context in use retains the caller's, so that no
  // other has its address.
  static auto* contexts = new std::map<std::pair<void*, void*>, WeakContext>;
  const std::lock_guard lock(Mutex());
  std::erase_if(*contexts, [](const auto& known) { return known.second.expired(); });
  const std::pair<void*, void*> key = {opencl_context, opencl_device};
  if (const auto known = contexts->find(key); known != contexts->end()) {
    EGOSIEVE_RETURN_IF_ERROR(kernels::CheckNotForked());
    if (SharedContext context = known->second.lock()) return context;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(SharedContext context,
                            kernels::AdoptContext(static_cast<cl_context>(opencl_context),
                                                  static_cast<cl_device_id>(opencl_device)));
  WeakContext& same = (*contexts)[{opencl_context, context->cl_device()()}];
  if (SharedContext known = same.lock()) context = std::move(known);
  same = context;
  (*contexts)[key] = context;
  return context;
}

}  // namespace egosieve::embed
