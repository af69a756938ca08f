// How many threads PoCL starts for its device, the machine's processors: by itself as many as the
// machine has, whatever of them the process may use.
#ifndef EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_
#define EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_

namespace egosieve::kernels {

// Limits them to `threads`, at least 1, or to what the environment says already where that is less.
// For programs, before OpenCL is used: a library must not change its process's environment.
void LimitPoclThreads(int threads);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_POCL_THREADS_H_
