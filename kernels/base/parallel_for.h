// Independent pieces of host work on all cores. What each piece computes must not depend on who
// runs it.
#ifndef EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_
#define EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_

#include <cstdint>
#include <functional>

namespace egosieve::kernels {

// Calls body(i) for 0 <= i < count, in any order, from several threads; returns when all are done.
// body must not throw.
void ParallelFor(int64_t count, const std::function<void(int64_t)>& body);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_
