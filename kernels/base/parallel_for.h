// Runs independent tasks on several host threads. Other threads are started only by pipelines of
// stages and by posteriors on several devices (kernels/ops/shared_posterior.cc).
//
// Every task does the same arithmetic on any thread and writes only its own results, so that
// results do not depend on the number of threads. Threads are started when a call finds no idle
// one, and kept until the process ends. A forked child starts its own threads. Calls may be nested.
#pragma once

#include <cstdint>
#include <limits>

#include "absl/functional/function_ref.h"

namespace egosieve::kernels {

struct ParallelLimits {
  // Largest number of threads, including the caller's; under 1: MaximumThreads().
  int threads = 0;
  // Approximate cost of all tasks together; little work uses fewer threads.
  double flops = std::numeric_limits<double>::infinity();
};

// Runs task(0), ..., task(count - 1), each once, and returns when all have ended. Tasks start in
// increasing order, and a thread runs a task as soon as it takes it. So a task may wait for the end
// of a task with smaller index, on any number of threads. If a task throws, no further task starts;
// once the running tasks have ended, one of the exceptions is thrown again here. A task that waits
// for another must stop waiting when that one throws. If the system refuses threads or memory for
// them, the call works without them: it throws nothing itself.
void ParallelFor(int64_t count, const ParallelLimits& limits,
                 absl::FunctionRef<void(int64_t)> task);
void ParallelFor(int64_t count, double flops, absl::FunctionRef<void(int64_t)> task);
void ParallelFor(int64_t count, absl::FunctionRef<void(int64_t)> task);

// Default limit on the threads of a ParallelFor, including the caller's, for the whole process.
// Initially it is $EGOSIEVE_THREADS, at most kMostThreads; if that is not a positive number, it is
// the number of available processors (processors.h). Values under 1 restore this.
inline constexpr int kMostThreads = 256;
void SetMaximumThreads(int threads);
int MaximumThreads();

}  // namespace egosieve::kernels
