// Why there is no OpenCL device.
#ifndef EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_
#define EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_

#include <string>

namespace egosieve::kernels {

// For a machine on which the loader found no device: what is wrong and what to do. Looks at the
// drivers that the loader looks at (OCL_ICD_VENDORS, else /etc/OpenCL/vendors): none is installed,
// one does not load, with the system's reason, or one loads and gives no device.
std::string WhyNoDevice();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_DRIVER_CHECK_H_
