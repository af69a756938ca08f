// egosieve devices: lists the devices for --device=.
#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/device.h"
#include "tools/cli/command.h"
#include "tools/cli/interruption.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {
namespace {

std::string MemoryText(int64_t bytes) {
  return bytes > 0 ? absl::StrFormat("%.1f GiB", static_cast<double>(bytes) / (1 << 30)) : "-";
}

std::string MakeTable(const std::vector<kernels::DeviceInfo>& devices, int chosen) {
  size_t width = 4;
  for (const kernels::DeviceInfo& device : devices) {
    width = std::max(width, device.name.size());
  }
  const int name_width = static_cast<int>(width);
  std::string table = absl::StrFormat("  %5s  %-11s  %-*s  %5s  %10s  %-7s  %s\n", "index", "type",
                                      name_width, "name", "units", "memory", "float64", "platform");
  for (const kernels::DeviceInfo& device : devices) {
    absl::StrAppendFormat(
        &table, "%s %5d  %-11s  %-*s  %5d  %10s  %-7s  %s\n", device.index == chosen ? "*" : " ",
        device.index, kernels::DeviceTypeName(device.type), name_width, device.name,
        device.compute_units, MemoryText(device.memory_bytes), device.float64 ? "yes" : "no",
        device.platform.substr(0, device.platform.find("  ")));
  }
  return table;
}

class DevicesCommand : public Command {
 public:
  std::string name() const override { return "devices"; }
  std::string summary() const override { return "Lists the devices that --device= can name."; }
  std::string example() const override {
    return "egosieve devices\negosieve segment drive.mp4 --out=out --device=gpu";
  }
  void AddFlags(CLI::App& app) override { result_.AddFlag(app); }

  absl::StatusOr<ExitCode> Run() override {
    EndOnInterruptions();
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<kernels::DeviceInfo> devices,
                              kernels::ListDevices());
    const char* environment = std::getenv("EGOSIEVE_DEVICE");
    const absl::StatusOr<kernels::DeviceInfo> chosen =
        kernels::ChooseDevice(devices, environment == nullptr ? "" : environment);
    std::string text = MakeTable(devices, chosen.ok() ? chosen->index : -1);
    absl::StrAppend(
        &text, chosen.ok() ? "* is used where --device is not given" : chosen.status().message(),
        "\n");
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const kernels::DeviceInfo& device : devices) {
      list.push_back({{"index", device.index},
                      {"type", kernels::DeviceTypeName(device.type)},
                      {"name", device.name},
                      {"platform", device.platform},
                      {"compute_units", device.compute_units},
                      {"memory_bytes", device.memory_bytes},
                      {"float64", device.float64},
                      {"default", chosen.ok() && chosen->index == device.index}});
    }
    result_.Tell(name(), {{"devices", list}}, text);
    return ExitCode::kDone;
  }

 private:
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeDevicesCommand() { return std::make_unique<DevicesCommand>(); }

}  // namespace egosieve::tools
