#include "kernels/runtime/device.h"

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_device.h"
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

absl::StatusOr<DeviceInfo> ChooseDefault(const std::vector<DeviceInfo>& devices) {
  for (const DeviceInfo& device : devices) {
    if (device.type == DeviceType::kGpu) return device;
  }
  for (const DeviceInfo& device : devices) {
    if (device.type != DeviceType::kReference) return device;
  }
  return absl::NotFoundError(WhyNoDevice());
}

}  // namespace

const char* DeviceTypeName(DeviceType type) {
  switch (type) {
    case DeviceType::kCpu:
      return "cpu";
    case DeviceType::kGpu:
      return "gpu";
    case DeviceType::kAccelerator:
      return "accelerator";
    case DeviceType::kReference:
      return "reference";
  }
  return "unknown";
}

DeviceInfo ReferenceDevice() {
  DeviceInfo reference;
  reference.name = "reference";
  reference.vendor = "host";
  reference.platform = "float64 arithmetic on the host";
  reference.type = DeviceType::kReference;
  reference.compute_units = 1;
  reference.float64 = true;
  return reference;
}

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

absl::StatusOr<std::vector<DeviceInfo>> ListDevices() {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<OpenClDevice> found, ListOpenClDevices());
  std::vector<DeviceInfo> devices;
  devices.reserve(found.size() + 1);
  for (const OpenClDevice& device : found) devices.push_back(device.info);
  devices.push_back(ReferenceDevice());
  devices.back().index = static_cast<int>(devices.size()) - 1;
  return devices;
}

absl::StatusOr<DeviceInfo> ChooseDevice(const std::vector<DeviceInfo>& devices,
                                        const std::string& choice) {
  if (choice.empty()) return ChooseDefault(devices);
  const std::string lower = absl::AsciiStrToLower(choice);
  int index;
  if (absl::SimpleAtoi(choice, &index)) {
    if (index >= 0 && index < static_cast<int>(devices.size())) return devices[index];
  } else {
    for (const DeviceInfo& device : devices) {
      if (lower == DeviceTypeName(device.type)) return device;
    }
    for (const DeviceInfo& device : devices) {
      if (absl::StrContains(absl::AsciiStrToLower(device.name), lower)) return device;
    }
  }
  const std::string names =
      absl::StrJoin(devices, ", ", [](std::string* out, const DeviceInfo& device) {
        absl::StrAppend(out, device.index, " (", device.name, ")");
      });
  return absl::NotFoundError(
      absl::StrCat("device \"", choice, "\" is not here; there are: ", names,
                   devices.size() <= 1 ? absl::StrCat("; ", WhyNoDevice()) : ""));
}

}  // namespace egosieve::kernels
