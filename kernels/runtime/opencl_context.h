// The contents of a Context: the device with its OpenCL context and its compiled programs.
//
// Several threads may use one Context at once. Programs are built under a lock, once each. Every
// operation borrows its own workspace and returns it for the next operation. A workspace has an
// in-order queue, kernel objects (whose arguments cannot be shared safely) and scratch memory. On
// PoCL's CPU its queue uses as many compute units as MaximumThreads() allows at that moment.
#pragma once

#include <CL/opencl.hpp>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::kernels {

class Context;

// Resources for one operation at a time.
class Workspace {
 public:
  // On the context's device or a part of it. Throws cl::Error.
  Workspace(Context& context, const cl::Device& device);

  const cl::CommandQueue& queue() const { return queue_; }
  const cl::Device& device() const { return device_; }
  // As Context::Kernel, but always the same object, which keeps its last arguments.
  absl::StatusOr<cl::Kernel> Kernel(std::string_view file, const std::string& options,
                                    const char* name, const std::string& covariance_code = "");
  // At least `bytes` of device memory, with the contents of the last use. Throws cl::Error.
  enum class Memory { kTiles, kQueries, kCounters };
  const cl::Buffer& Scratch(Memory memory, size_t bytes);

 private:
  struct Grown {
    cl::Buffer buffer;
    size_t bytes = 0;
  };

  Context& context_;
  cl::Device device_;
  cl::CommandQueue queue_;
  std::map<std::string, cl::Kernel> kernels_;
  std::array<Grown, 3> scratch_;
};

class Context {
 public:
  // For the reference.
  explicit Context(DeviceInfo info) : info_(std::move(info)) {}
  // With a null `context` it creates its own.
  Context(DeviceInfo info, cl::Device device, const ContextOptions& options,
          cl::Context context = cl::Context());

  const DeviceInfo& info() const { return info_; }
  bool is_reference() const { return info_.type == DeviceType::kReference; }
  bool is_gpu() const { return info_.type == DeviceType::kGpu; }
  // Whether buffers can be the caller's own memory, without copies.
  bool shares_host_memory() const { return shares_host_memory_; }
  const KernelTuning& tuning() const { return tuning_; }
  // Of a work-group. Throws cl::Error.
  int64_t local_memory_bytes() const;

  const cl::Context& cl_context() const { return context_; }
  const cl::Device& cl_device() const { return device_; }

  // A workspace that is not in use, an idle one if possible; `doing` is for the error message. A
  // successful operation returns it with GiveBack; after an error it is dropped, since its queue
  // may be unusable.
  absl::StatusOr<std::unique_ptr<Workspace>> Borrow(std::string_view doing);
  void GiveBack(std::unique_ptr<Workspace> workspace);
  // Frees the idle workspaces with their memory.
  void ReleaseIdle();

  // A new kernel object of the function `name` in the .cl file `file`, after common.cl and
  // `covariance_code`; built with `options` at the first call.
  absl::StatusOr<cl::Kernel> Kernel(std::string_view file, const std::string& options,
                                    const char* name, const std::string& covariance_code = "");

 private:
  absl::StatusOr<cl::Program> Program(std::string_view file, const std::string& options,
                                      const std::string& covariance_code);
  // The device, or the part of PoCL's CPU that MaximumThreads() allows. Throws cl::Error.
  cl::Device DeviceOfCall() const;

  DeviceInfo info_;
  cl::Device device_;
  cl::Context context_;
  bool shares_host_memory_ = false;
  KernelTuning tuning_;
  int64_t most_local_memory_bytes_ = 0;  // 0: no limit but the device's
  // A std::mutex, because Debian's absl::Mutex is not instrumented for the thread sanitizer.
  std::mutex mutex_;
  std::map<std::string, cl::Program> programs_;   // guarded by mutex_
  absl::Status lost_compiler_;                    // guarded by mutex_; why building has stopped
  std::vector<std::unique_ptr<Workspace>> idle_;  // guarded by mutex_
};

// A context on the caller's OpenCL context, so that operations accept its queues and memory; both
// are retained. device: one of the context's; null: its first. options.device is ignored.
absl::StatusOr<std::shared_ptr<Context>> AdoptContext(cl_context context, cl_device_id device,
                                                      const ContextOptions& options = {});

}  // namespace egosieve::kernels
