// The flag --device: the device for the dense arithmetic.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

struct OpenedDevice {
  std::shared_ptr<kernels::Context> context;
  kernels::DeviceInfo info;
};

// The device and its platform on one short line.
std::string DescribeDevice(const kernels::DeviceInfo& device);

class DeviceFlag {
 public:
  void AddFlag(CLI::App& app);

  // Naming a device that does not exist is a usage error; having no device at all is an error of
  // the environment. A device that is the processor gets at most MaximumThreads() threads.
  absl::StatusOr<OpenedDevice> Open() const;

 private:
  std::string device_;
};

}  // namespace egosieve::tools
