#include "tools/cli/device_flag.h"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/standard_streams.h"

namespace egosieve::tools {

std::string DescribeDevice(const kernels::DeviceInfo& device) {
  // Platforms append their build options after two spaces.
  return absl::StrCat(device.name, " (", device.platform.substr(0, device.platform.find("  ")),
                      ")");
}

void DeviceFlag::AddFlag(CLI::App& app) {
  app.add_option("--device", device_,
                 "A device's index, a part of its name, cpu, gpu or reference (see egosieve "
                 "devices); default: $EGOSIEVE_DEVICE, else a GPU, else a CPU")
      ->type_name("DEVICE");
}

absl::StatusOr<OpenedDevice> DeviceFlag::Open() const {
  std::string choice = device_;
  if (const char* environment = std::getenv("EGOSIEVE_DEVICE");
      choice.empty() && environment != nullptr) {
    choice = environment;
  }
  const auto as_error = [&](const absl::Status& status) {
    return choice.empty() ? absl::UnavailableError(status.message()) : AsUsageError(status);
  };
  OpenedDevice opened;
  kernels::ContextOptions options;
  if (choice == "reference") {  // must work even with a broken driver
    opened.info = kernels::ReferenceDevice();
    options.device = choice;
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<kernels::DeviceInfo> devices,
                              kernels::ListDevices());
    absl::StatusOr<kernels::DeviceInfo> info = kernels::ChooseDevice(devices, choice);
    if (!info.ok()) {
      return as_error(info.status());
    }
    opened.info = *std::move(info);
    options.device = absl::StrCat(opened.info.index);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(opened.context, kernels::OpenContext(options));
  WatchForAborts();
  return opened;
}

}  // namespace egosieve::tools
