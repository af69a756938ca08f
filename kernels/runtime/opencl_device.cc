#include "kernels/runtime/opencl_device.h"

#include "absl/strings/match.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/fork_guard.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace {

DeviceType TypeOf(const cl::Device& device) {
  const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
  if (type & CL_DEVICE_TYPE_GPU) return DeviceType::kGpu;
  if (type & CL_DEVICE_TYPE_CPU) return DeviceType::kCpu;
  return DeviceType::kAccelerator;
}

// The bindings throw if the loader finds no platform; here that is not an error.
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

DeviceInfo DescribeDevice(const cl::Device& device) {
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  DeviceInfo info;
  info.index = -1;
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

absl::StatusOr<std::vector<OpenClDevice>> ListOpenClDevices() {
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  EGOSIEVE_RETURN_IF_ERROR(CheckDriversCanStart());
  std::vector<OpenClDevice> found;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("listing OpenCL devices", [&] {
    for (const cl::Platform& platform : Platforms()) {
      for (const cl::Device& device : Devices(platform)) {
        found.push_back({device, DescribeDevice(device)});
        found.back().info.index = static_cast<int>(found.size()) - 1;
      }
    }
  }));
  return found;
}

}  // namespace egosieve::kernels
