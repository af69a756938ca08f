// OpenCL drivers do not survive fork: the child has none of their threads, and its first command
// would wait forever. The first use of a driver is recorded with its process; processes forked from
// it get an error at every use.
#pragma once

#include "absl/status/status.h"

namespace egosieve::kernels {

// Call it before any driver. FailedPrecondition, with a remedy, if an ancestor of this process used
// a driver before it forked.
absl::Status CheckNotForked();

}  // namespace egosieve::kernels
