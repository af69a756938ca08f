// Limits the threads of PoCL's device. By default PoCL starts as many as the computer has
// processors, even if the process may use fewer.
#ifndef EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_
#define EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_

namespace egosieve::kernels {

// Limits them to `threads`, at least 1, or to the environment's value if that is less. For
// programs, before OpenCL is used: a library must not change its process's environment.
void LimitPoclThreads(int threads);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_
