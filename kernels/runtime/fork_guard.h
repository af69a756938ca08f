// OpenCL drivers do not survive fork: the child has none of their threads, and its first command
// would wait for ever. The first use of a driver is remembered with its process; in another process
// that was forked from it every use is refused.
#ifndef EGOSIEVE_KERNELS_RUNTIME_FORK_GUARD_H_
#define EGOSIEVE_KERNELS_RUNTIME_FORK_GUARD_H_

#include "absl/status/status.h"

namespace egosieve::kernels {

// To be called before a driver is: FailedPrecondition, saying what to do, where an ancestor of this
// process has used one before it forked.
absl::Status CheckNotForked();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_FORK_GUARD_H_
