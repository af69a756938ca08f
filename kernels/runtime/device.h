// The devices for the operations: every OpenCL device of every platform, then the float64
// reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::kernels {

enum class DeviceType { kCpu, kGpu, kAccelerator, kReference };

// "cpu", "gpu", "accelerator", "reference".
const char* DeviceTypeName(DeviceType type);

struct DeviceInfo {
  int index = 0;  // as for ContextOptions::device
  std::string name;
  std::string vendor;
  std::string platform;
  std::string version;  // of OpenCL
  std::string driver;
  DeviceType type = DeviceType::kCpu;
  int compute_units = 0;
  int64_t memory_bytes = 0;
  bool float64 = false;
};

// The float64 arithmetic on the host, without any driver.
DeviceInfo ReferenceDevice();

// Never empty: the reference is always the last element, and the only one on a computer without an
// OpenCL platform. Errors are those of a broken driver.
absl::StatusOr<std::vector<DeviceInfo>> ListDevices();

// The element of `devices` that `choice` names: an index, "cpu", "gpu", "reference", or a part of a
// device's name in upper or lower case; empty: the first GPU, else the first CPU or accelerator.
// NotFound, naming the devices or the packages to install, if there is none.
absl::StatusOr<DeviceInfo> ChooseDevice(const std::vector<DeviceInfo>& devices,
                                        const std::string& choice);

}  // namespace egosieve::kernels
