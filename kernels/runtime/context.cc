#include "kernels/runtime/context.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include "absl/algorithm/container.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/cl/sources.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/opencl_device.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace {

constexpr char kPoclHint[] = "; POCL_CACHE_DIR can name another folder for PoCL's programs";

bool IsPocl(const DeviceInfo& device) {
  return absl::StrContains(device.platform, "Portable Computing Language");
}

KernelTuning DefaultsOf(const cl::Device& device, DeviceType type) {
  if (type == DeviceType::kGpu) return DefaultGpuTuning();
  // PoCL reports the width of its target; some drivers report 1 or odd values.
  const cl_uint native = device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>();
  return DefaultTuning(native >= 16 ? 16 : native >= 8 ? 8 : 4);
}

// The text of a .cl file, with each line #include "other.cl" replaced by the text of that file.
std::string SourceOf(std::string_view file) {
  constexpr std::string_view kInclude = "\n#include \"";
  std::string text(cl_sources::Text(file));
  for (size_t at = text.find(kInclude); at != std::string::npos; at = text.find(kInclude, at)) {
    const size_t name = at + kInclude.size();
    const size_t end = text.find('"', name);
    text.replace(at + 1, end - at, SourceOf(text.substr(name, end - name)));
  }
  return text;
}

// A program whose build has failed is dropped, not released: after some failures, such as a lack of
// memory, PoCL 3.1 keeps the program's lock held, and clReleaseProgram would wait for it forever.
void Build(cl::Program& program, const cl::Device& device, const std::string& options) {
  try {
    // Program::build would request the log after any error, and throw that request's error instead.
    const cl_int code = clBuildProgram(program(), 1, &device(), options.c_str(), nullptr, nullptr);
    if (code == CL_BUILD_PROGRAM_FAILURE) {
      throw cl::BuildError(code, "clBuildProgram", program.getBuildInfo<CL_PROGRAM_BUILD_LOG>());
    }
    if (code != CL_SUCCESS) throw cl::Error(code, "clBuildProgram");
  } catch (...) {
    program() = nullptr;
    throw;
  }
}

// The first `compute_units` of the device; all of them where the driver cannot divide it.
cl::Device CreatePart(cl::Device device, int compute_units) {
  const std::array<cl_device_partition_property, 4> by_count = {
      CL_DEVICE_PARTITION_BY_COUNTS, compute_units, CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
  try {
    std::vector<cl::Device> parts;
    device.createSubDevices(by_count.data(), &parts);
    return parts.at(0);
  } catch (const cl::Error& error) {
    constexpr cl_int kCannot[] = {CL_INVALID_VALUE, CL_INVALID_DEVICE, CL_DEVICE_PARTITION_FAILED};
    if (absl::c_find(kCannot, error.err()) == std::end(kCannot)) throw;
    return device;
  }
}

// The part stays until the process ends: PoCL's queues do not keep theirs, and its threads read it
// a moment after a call has ended, when the context may be gone.
cl::Device PartOf(const cl::Device& device, int compute_units) {
  static std::mutex mutex;
  static auto& parts = *new std::map<std::pair<cl_device_id, int>, cl::Device>;
  const std::lock_guard lock(mutex);
  const std::pair key(device(), compute_units);
  const auto found = parts.find(key);
  return found != parts.end() ? found->second
                              : parts.emplace(key, CreatePart(device, compute_units)).first->second;
}

}  // namespace

Workspace::Workspace(Context& context, const cl::Device& device)
    : context_(context), device_(device), queue_(context.cl_context(), device) {}

absl::StatusOr<cl::Kernel> Workspace::Kernel(std::string_view file, const std::string& options,
                                             const char* name, const std::string& covariance_code) {
  const std::string key =
      absl::StrCat(name, "\n", std::string(file), "\n", options, "\n", covariance_code);
  if (const auto found = kernels_.find(key); found != kernels_.end()) return found->second;
  EGOSIEVE_ASSIGN_OR_RETURN(const cl::Kernel kernel,
                            context_.Kernel(file, options, name, covariance_code));
  kernels_.emplace(key, kernel);
  return kernel;
}

const cl::Buffer& Workspace::Scratch(Memory memory, size_t bytes) {
  Grown& grown = scratch_[static_cast<size_t>(memory)];
  if (grown.bytes < bytes) {
    grown = Grown();
    grown.buffer = cl::Buffer(context_.cl_context(), CL_MEM_READ_WRITE, bytes);
    grown.bytes = bytes;
  }
  return grown.buffer;
}

Context::Context(DeviceInfo info, cl::Device device, const ContextOptions& options,
                 cl::Context context)
    : info_(std::move(info)),
      device_(std::move(device)),
      context_(context() == nullptr ? cl::Context(device_) : std::move(context)),
      most_local_memory_bytes_(options.local_memory_bytes) {
  info_.float64 = info_.float64 && options.float64;
  shares_host_memory_ = info_.type == DeviceType::kCpu && options.shared_memory;
  tuning_ = options.tuning.has_value() ? *options.tuning
                                       : LoadTuning(info_, DefaultsOf(device_, info_.type));
}

int64_t Context::local_memory_bytes() const {
  const auto bytes = static_cast<int64_t>(device_.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>());
  return most_local_memory_bytes_ > 0 ? std::min(bytes, most_local_memory_bytes_) : bytes;
}

absl::StatusOr<cl::Program> Context::Program(std::string_view file, const std::string& options,
                                             const std::string& covariance_code) {
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  const std::lock_guard lock(mutex_);
  const std::string key = absl::StrCat(std::string(file), "\n", options, "\n", covariance_code);
  if (const auto found = programs_.find(key); found != programs_.end()) {
    return found->second;
  }
  EGOSIEVE_RETURN_IF_ERROR(lost_compiler_);
  cl::Program program;
  const absl::Status status =
      CatchOpenClErrors("building " + std::string(file) + " for " + info_.name, [&] {
        program = cl::Program(context_, SourceOf("common.cl") + covariance_code + SourceOf(file));
        Build(program, device_, options);
      });
  if (!status.ok()) {
    // They are dropped like the failed program. PoCL 3.1 may have kept its
    // compiler's lock, for which the release of any program waits, and, after a lack of memory,
    // also the next build.
    for (auto& [name, built] : programs_) built() = nullptr;
    programs_.clear();
    if (!IsPocl(info_)) return status;
    if (absl::IsResourceExhausted(status)) lost_compiler_ = status;
    const absl::Status room = CheckPoclCanWrite();
    return room.ok() ? status : absl::Status(room.code(), absl::StrCat(room.message(), kPoclHint));
  }
  programs_.emplace(key, program);
  return program;
}

absl::StatusOr<cl::Kernel> Context::Kernel(std::string_view file, const std::string& options,
                                           const char* name, const std::string& covariance_code) {
  EGOSIEVE_ASSIGN_OR_RETURN(const cl::Program program, Program(file, options, covariance_code));
  cl::Kernel kernel;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(std::string("creating the kernel ") + name,
                                             [&] { kernel = cl::Kernel(program, name); }));
  return kernel;
}

cl::Device Context::DeviceOfCall() const {
  const int units = std::min(info_.compute_units, MaximumThreads());
  // By the standard a part needs a context and programs of its own; PoCL's take the device's.
  if (!IsPocl(info_) || info_.type != DeviceType::kCpu || units == info_.compute_units) {
    return device_;
  }
  return PartOf(device_, units);
}

absl::StatusOr<std::unique_ptr<Workspace>> Context::Borrow(std::string_view doing) {
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  std::unique_ptr<Workspace> workspace;
  cl::Device device;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(doing, [&] { device = DeviceOfCall(); }));
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(idle_, [&](const auto& idle) { return idle->device()() != device(); });
    if (!idle_.empty()) {
      workspace = std::move(idle_.back());
      idle_.pop_back();
      return workspace;
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(
      CatchOpenClErrors(doing, [&] { workspace = std::make_unique<Workspace>(*this, device); }));
  return workspace;
}

void Context::GiveBack(std::unique_ptr<Workspace> workspace) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(workspace));
}

void Context::ReleaseIdle() {
  std::vector<std::unique_ptr<Workspace>> idle;
  const std::lock_guard lock(mutex_);
  idle.swap(idle_);
}

absl::StatusOr<std::shared_ptr<Context>> AdoptContext(cl_context context, cl_device_id device,
                                                      const ContextOptions& options) {
  if (options.tuning.has_value()) EGOSIEVE_RETURN_IF_ERROR(options.tuning->Validate());
  EGOSIEVE_REQUIRE(InvalidArgument, context != nullptr, "the OpenCL context is null");
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  std::shared_ptr<Context> adopted;
  bool belongs = false;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("adopting an OpenCL context", [&] {
    const cl::Context theirs(context, /*retainObject=*/true);
    for (const cl::Device& one : theirs.getInfo<CL_CONTEXT_DEVICES>()) {
      if (device != nullptr && one() != device) continue;
      belongs = true;
      adopted = std::make_shared<Context>(DescribeDevice(one), one, options, theirs);
      break;
    }
  }));
  EGOSIEVE_REQUIRE(InvalidArgument, belongs, "the device is none of the OpenCL context's");
  return adopted;
}

absl::StatusOr<std::shared_ptr<Context>> OpenContext(const ContextOptions& options) {
  if (options.tuning.has_value()) EGOSIEVE_RETURN_IF_ERROR(options.tuning->Validate());
  const char* environment = std::getenv("EGOSIEVE_DEVICE");
  const std::string choice =
      options.device.empty() && environment != nullptr ? environment : options.device;
  // Does not query the drivers: the reference must work even if they are broken.
  if (choice == "reference") return std::make_shared<Context>(ReferenceDevice());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<DeviceInfo> devices, ListDevices());
  EGOSIEVE_ASSIGN_OR_RETURN(const DeviceInfo chosen, ChooseDevice(devices, choice));
  if (chosen.type == DeviceType::kReference) return std::make_shared<Context>(chosen);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<OpenClDevice> opencl_devices, ListOpenClDevices());
  std::shared_ptr<Context> context;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("opening " + chosen.name, [&] {
    context = std::make_shared<Context>(chosen, opencl_devices.at(chosen.index).device, options);
  }));
  return context;
}

}  // namespace egosieve::kernels
