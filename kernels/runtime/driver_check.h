// Reasons for a missing OpenCL device, and whether the drivers can be queried safely.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace egosieve::kernels {

// For a computer on which the loader found no device: the fault and its remedy. Examines the same
// drivers as the loader (OCL_ICD_VENDORS, else /etc/OpenCL/vendors): none is installed; one does
// not load, with the system's reason; or one loads and has no device.
std::string WhyNoDevice();

// Unavailable, with a remedy, if PoCL is installed and would abort the process while it searches
// for processors, because `processors`, the kernel's list of them, is missing (/sys is not
// mounted).
absl::Status CheckDriversCanStart(const std::string& processors = "/sys/devices/system/cpu");

}  // namespace egosieve::kernels
