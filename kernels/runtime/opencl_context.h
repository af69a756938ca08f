// What a Context is inside: the device with its OpenCL context and its compiled programs.
//
// One Context may be used by several threads at once: programs are built under a lock, once each;
// every operation makes its own in-order queue and its own kernel objects (whose arguments are not
// safe to share).
#ifndef EGOSIEVE_KERNELS_RUNTIME_OPENCL_CONTEXT_H_
#define EGOSIEVE_KERNELS_RUNTIME_OPENCL_CONTEXT_H_

#include <CL/opencl.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::kernels {

class Context {
 public:
  // The reference.
  explicit Context(DeviceInfo info) : info_(std::move(info)) {}
  Context(DeviceInfo info, cl::Device device, const ContextOptions& options);

  const DeviceInfo& info() const { return info_; }
  bool is_reference() const { return info_.type == DeviceType::kReference; }
  bool is_gpu() const { return info_.type == DeviceType::kGpu; }
  // Buffers can be the caller's own memory, without copies.
  bool shares_host_memory() const { return shares_host_memory_; }
  const KernelTuning& tuning() const { return tuning_; }

  const cl::Context& cl_context() const { return context_; }
  const cl::Device& cl_device() const { return device_; }
  cl::CommandQueue NewQueue() const { return cl::CommandQueue(context_, device_); }

  // A new kernel object of the function `name` in the .cl file `file`, built with `options` the
  // first time, after common.cl and `covariance_code`.
  absl::StatusOr<cl::Kernel> Kernel(std::string_view file, const std::string& options,
                                    const char* name, const std::string& covariance_code = "");

 private:
  absl::StatusOr<cl::Program> Program(std::string_view file, const std::string& options,
                                      const std::string& covariance_code);

  DeviceInfo info_;
  cl::Device device_;
  cl::Context context_;
  bool shares_host_memory_ = false;
  bool program_cache_ = false;
  KernelTuning tuning_;
  // The thread sanitizer sees into this mutex; into Debian's absl::Mutex it does not.
  std::mutex mutex_;
  std::map<std::string, cl::Program> programs_;  // guarded by mutex_
};

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_OPENCL_CONTEXT_H_
