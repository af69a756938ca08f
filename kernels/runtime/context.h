// Opens an OpenCL device, or the float64 reference on the host.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::kernels {

struct ContextOptions {
  // An index of ListDevices(), a part of a device's name, "cpu", "gpu" or "reference". Empty: the
  // environment variable EGOSIEVE_DEVICE; if that is not set, a GPU if there is one, else a CPU.
  std::string device;
  // False: treats the device as one without float64; operations that need it run on the host.
  bool float64 = true;
  // False: treats the device as one with its own memory, even a CPU: arrays are copied to it and
  // back.
  bool shared_memory = true;
  // Above 0: treats the device as one whose work-groups have at most so much local memory.
  int64_t local_memory_bytes = 0;
  // Shapes of the kernels. Not set: the device's table in the user's cache folder, else defaults.
  std::optional<KernelTuning> tuning;
};

class Context;
using Contexts = std::vector<std::shared_ptr<Context>>;

// FailedPrecondition, here and from all later operations on the context, in a process that was
// forked from one that had used OpenCL.
absl::StatusOr<std::shared_ptr<Context>> OpenContext(const ContextOptions& options = {});

}  // namespace egosieve::kernels
