// One OpenCL device ready for work, or the float64 reference on the host.
#ifndef EGOSIEVE_KERNELS_RUNTIME_CONTEXT_H_
#define EGOSIEVE_KERNELS_RUNTIME_CONTEXT_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::kernels {

struct ContextOptions {
  // An index of ListDevices(), a part of a device's name, "cpu", "gpu" or "reference". Empty: the
  // environment variable EGOSIEVE_DEVICE; if that is unset, a GPU if there is one, else a CPU.
  std::string device;
  // Compiled programs are kept in the user's cache folder.
  bool program_cache = true;
  // False: as on a device without it; what needs it is computed on the host.
  bool float64 = true;
  // False: as on a device with memory of its own, which a CPU has not: arrays are copied to it and
  // back.
  bool shared_memory = true;
  // Shapes of the kernels. Unset: the device's table in the user's cache folder, else defaults.
  std::optional<KernelTuning> tuning;
};

class Context;

// FailedPrecondition, here and from all that computes on the context later, in a process that was
// forked from one that had used OpenCL.
absl::StatusOr<std::shared_ptr<Context>> OpenContext(const ContextOptions& options = {});

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_CONTEXT_H_
