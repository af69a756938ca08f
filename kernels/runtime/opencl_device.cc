#include "kernels/runtime/opencl_device.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace {

DeviceType TypeOf(const cl::Device& device) {
  const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
  if (type & CL_DEVICE_TYPE_GPU) return DeviceType::kGpu;
  if (type & CL_DEVICE_TYPE_CPU) return DeviceType::kCpu;
  return DeviceType::kAccelerator;
}

DeviceInfo Describe(const cl::Device& device, const cl::Platform& platform) {
  DeviceInfo info;
  info.name = device.getInfo<CL_DEVICE_NAME>();
  info.vendor = device.getInfo<CL_DEVICE_VENDOR>();
  info.platform =
      platform.getInfo<CL_PLATFORM_NAME>() + " " + platform.getInfo<CL_PLATFORM_VERSION>();
  info.version = device.getInfo<CL_DEVICE_VERSION>();
  info.driver = device.getInfo<CL_DRIVER_VERSION>();
  info.type = TypeOf(device);
  info.compute_units = static_cast<int>(device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>());
  info.memory_bytes = static_cast<int64_t>(device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>());
  info.float64 = absl::StrContains(device.getInfo<CL_DEVICE_EXTENSIONS>(), "cl_khr_fp64");
  return info;
}

// Whether a file can be made in `folder`, or in the nearest parent that exists.
bool CanWriteBelow(std::string folder) {
  while (access(folder.c_str(), F_OK) != 0) {
    const size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) return false;
    folder.resize(slash);
  }
  return access(folder.c_str(), W_OK | X_OK) == 0;
}

// PoCL keeps what it compiles in a folder of its own and fails to build anything where it cannot
// write there (a home that is read-only, a sandbox). Then it is given a private folder among the
// temporary files. Returns whether it did so.
bool EnsurePoclCanWrite() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr) return false;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache != nullptr && CanWriteBelow(absl::StrCat(cache, "/pocl/kcache"))) return false;
  if (cache == nullptr && home != nullptr &&
      CanWriteBelow(absl::StrCat(home, "/.cache/pocl/kcache")))
    return false;
  const char* temporary = std::getenv("TMPDIR");
  const std::string folder =
      absl::StrCat(temporary != nullptr ? temporary : "/tmp", "/egosieve-pocl-", getuid());
  mkdir(folder.c_str(), 0700);
  struct stat status;
  return lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == getuid() && setenv("POCL_CACHE_DIR", folder.c_str(), 0) == 0;
}

// The bindings throw where the loader finds nothing; that is no error here.
std::vector<cl::Platform> Platforms() {
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error& error) {
    constexpr cl_int kPlatformNotFound = -1001;
    if (error.err() != kPlatformNotFound) throw;
  }
  return platforms;
}

std::vector<cl::Device> Devices(const cl::Platform& platform) {
  std::vector<cl::Device> devices;
  try {
    platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
  } catch (const cl::Error& error) {
    if (error.err() != CL_DEVICE_NOT_FOUND) throw;
  }
  return devices;
}

}  // namespace

absl::StatusOr<std::vector<OpenClDevice>> ListOpenClDevices() {
  // Before the first call into a driver, once.
  [[maybe_unused]] static const bool redirected = EnsurePoclCanWrite();
  std::vector<OpenClDevice> found;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("listing OpenCL devices", [&] {
    for (const cl::Platform& platform : Platforms()) {
      for (const cl::Device& device : Devices(platform)) {
        found.push_back({device, Describe(device, platform)});
        found.back().info.index = static_cast<int>(found.size()) - 1;
      }
    }
  }));
  return found;
}

}  // namespace egosieve::kernels
