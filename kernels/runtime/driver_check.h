// Why there is no OpenCL device, and whether the drivers can be asked for theirs.
#ifndef EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_
#define EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_

#include <string>

#include "absl/status/status.h"

namespace egosieve::kernels {

// For a machine on which the loader found no device: what is wrong and what to do. Looks at the
// drivers that the loader looks at (OCL_ICD_VENDORS, else /etc/OpenCL/vendors): none is installed,
// one does not load, with the system's reason, or one loads and gives no device.
std::string WhyNoDevice();

// Unavailable, with what to do, where PoCL is installed and would abort the process as it looks for
// the processors: `processors`, where the kernel lists them, is missing because /sys is not
// mounted.
absl::Status CheckDriversCanStart(const std::string& processors = "/sys/devices/system/cpu");

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_
