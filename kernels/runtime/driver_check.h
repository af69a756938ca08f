// Whether OpenCL drivers can be used safely: reasons for a missing device, processes that were forked,
// and the folder of PoCL's compiled programs.
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

// OpenCL drivers do not survive fork: the child has none of their threads, and its first command would
// wait forever. The first use of a driver is recorded with its process. Call it before any driver:
// FailedPrecondition, with a remedy, if an ancestor of this process used a driver before it forked.
absl::Status CheckNotForked();

// The folder of PoCL's compiled programs. If PoCL cannot write there (a read-only home, a sandbox), it
// builds nothing or offers no device; if the folder is damaged, it ends the process.
// $POCL_CACHE_DIR, else pocl/kcache below $XDG_CACHE_HOME or $HOME/.cache; empty if none of them is
// set.
std::string PoclCacheFolder();

// Whether there is room for a program in that folder, tried by writing a temporary file; else a
// status that says why not.
absl::Status CheckPoclCanWrite();

// If the permissions do not let PoCL write there, sets POCL_CACHE_DIR to a private temporary folder. For
// programs, before they start threads: a library must not change its process's environment.
void LetPoclWrite();

}  // namespace egosieve::kernels
