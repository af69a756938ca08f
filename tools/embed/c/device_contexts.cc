#include "tools/embed/c/device_contexts.h"

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>

#include "kernels/base/status_macros.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::embed {

absl::StatusOr<std::shared_ptr<kernels::Context>> ContextOf(const char* device) {
  static std::mutex* mutex = new std::mutex;
  static auto* contexts = new std::map<std::string, std::weak_ptr<kernels::Context>>;
  kernels::ContextOptions options;
  if (device != nullptr) options.device = device;
  if (const char* environment = std::getenv("EGOSIEVE_DEVICE");
      options.device.empty() && environment != nullptr) {
    options.device = environment;
  }
  std::lock_guard lock(*mutex);
  std::weak_ptr<kernels::Context>& known = (*contexts)[options.device];
  if (std::shared_ptr<kernels::Context> context = known.lock()) return context;
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<kernels::Context> context,
                            kernels::OpenContext(options));
  known = context;
  return context;
}

absl::StatusOr<std::shared_ptr<kernels::Context>> ContextOn(void* opencl_context,
                                                            void* opencl_device) {
  return kernels::AdoptContext(static_cast<cl_context>(opencl_context),
                               static_cast<cl_device_id>(opencl_device));
}

}  // namespace egosieve::embed
