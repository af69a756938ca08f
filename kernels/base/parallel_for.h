// Independent tasks of host work on several threads: the one place where the libraries start any.
//
// Every task does the same arithmetic whichever thread runs it and writes to places of its own, so
// that results do not depend on the number of threads. Threads are started when a call finds no
// idle one and then kept until the process ends; handing tasks to them costs some microseconds. A
// forked child starts its own. Calls may nest.
#ifndef EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_
#define EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_

#include <cstdint>
#include <functional>
#include <limits>

namespace egosieve::kernels {

struct ParallelLimits {
  // The most threads, the caller's included; under 1: MaximumThreads().
  int threads = 0;
  // Roughly what all tasks cost together: little work is left to fewer threads.
  double flops = std::numeric_limits<double>::infinity();
};

// Runs task(0), ..., task(count - 1), each once, and returns when all have ended. Tasks are taken
// in increasing order, each by a thread that starts it at once: one may wait for the end of another
// of smaller index, on any number of threads. Where one throws, no further task starts, and when
// those that run have ended the exception is thrown again here, one of several; a task that waits
// for another's end must stop waiting when that one throws. Threads that the system refuses are
// done without.
void ParallelFor(int64_t count, const ParallelLimits& limits,
                 const std::function<void(int64_t)>& task);
void ParallelFor(int64_t count, double flops, const std::function<void(int64_t)>& task);
void ParallelFor(int64_t count, const std::function<void(int64_t)>& task);

// The most threads of a ParallelFor that is given no number, the caller's included, for the whole
// process; at first $EGOSIEVE_THREADS, at most kMostThreads, and where that is no positive number,
// as many as there are processors for it (processors.h). Values under 1 mean that.
inline constexpr int kMostThreads = 256;
void SetMaximumThreads(int threads);
int MaximumThreads();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_PARALLEL_FOR_H_
