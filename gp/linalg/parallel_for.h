// Sharing independent tasks among threads.
//
// Every task does the same arithmetic whichever thread runs it, so that results do not depend on
// the number of threads. Threads live for one call: nothing is left running between calls, across
// fork or at exit; starting them costs some tens of microseconds, so tasks should be worth that.
#ifndef EGOSIEVE_GP_LINALG_PARALLEL_FOR_H_
#define EGOSIEVE_GP_LINALG_PARALLEL_FOR_H_

#include <cstdint>
#include <functional>

namespace egosieve::gp {

// Runs task(0), ..., task(count - 1), each once, and returns when all have ended. Tasks start in
// increasing order, so one may wait for the end of another of smaller index. They must not throw.
// flops: roughly what all of them cost together; little work is left to fewer threads.
void ParallelFor(int64_t count, double flops, const std::function<void(int64_t)>& task);

// The most threads that one ParallelFor uses, the caller's included; at first as many as the
// machine has processors. Values under 1 mean that.
void SetMaximumThreads(int threads);
int MaximumThreads();

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_LINALG_PARALLEL_FOR_H_
