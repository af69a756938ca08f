#include "kernels/runtime/device.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_device.h"

namespace egosieve::kernels {

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

absl::StatusOr<std::vector<DeviceInfo>> ListDevices() {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<OpenClDevice> found, ListOpenClDevices());
  std::vector<DeviceInfo> devices;
  devices.reserve(found.size() + 1);
  for (const OpenClDevice& device : found) devices.push_back(device.info);
  devices.push_back(ReferenceDevice());
  devices.back().index = static_cast<int>(devices.size()) - 1;
  return devices;
}

namespace {

absl::StatusOr<DeviceInfo> ChooseDefault(const std::vector<DeviceInfo>& devices) {
  for (const DeviceInfo& device : devices) {
    if (device.type == DeviceType::kGpu) return device;
  }
  for (const DeviceInfo& device : devices) {
    if (device.type != DeviceType::kReference) return device;
  }
  return absl::NotFoundError(WhyNoDevice());
}

bool Matches(const DeviceInfo& device, const std::string& lower_choice) {
  return lower_choice == DeviceTypeName(device.type);
}

bool NameContains(const DeviceInfo& device, const std::string& lower_choice) {
  return absl::StrContains(absl::AsciiStrToLower(device.name), lower_choice);
}

}  // namespace

absl::StatusOr<DeviceInfo> ChooseDevice(const std::vector<DeviceInfo>& devices,
                                        const std::string& choice) {
  if (choice.empty()) return ChooseDefault(devices);
  const std::string lower = absl::AsciiStrToLower(choice);
  int index;
  if (absl::SimpleAtoi(choice, &index)) {
    if (index >= 0 && index < static_cast<int>(devices.size())) return devices[index];
  } else {
    for (const auto predicate : {&Matches, &NameContains}) {
      const auto found =
          std::find_if(devices.begin(), devices.end(),
                       [&](const DeviceInfo& device) { return predicate(device, lower); });
      if (found != devices.end()) return *found;
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
