// OpenCL devices with their descriptions, in the order of the platforms.
#pragma once

#include <CL/opencl.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/device.h"

namespace egosieve::kernels {

struct OpenClDevice {
  cl::Device device;
  DeviceInfo info;
};

// Throws cl::Error. Its index is not that of any device.
DeviceInfo DescribeDevice(const cl::Device& device);

// Empty if there is no platform or no device.
absl::StatusOr<std::vector<OpenClDevice>> ListOpenClDevices();

}  // namespace egosieve::kernels
