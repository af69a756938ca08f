// The flag --device: on what the dense arithmetic runs.
#ifndef EGOSIEVE_TOOLS_CLI_DEVICE_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_DEVICE_FLAG_H_

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"

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

  // A device that was named and is not there is a usage error; none at all is the environment's.
  // One that is the processor gets no more than MaximumThreads().
  absl::StatusOr<OpenedDevice> Open() const;

 private:
  std::string device_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_DEVICE_FLAG_H_
