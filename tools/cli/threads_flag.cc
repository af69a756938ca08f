#include "tools/cli/threads_flag.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "kernels/base/parallel_for.h"
#include "tools/cli/checks.h"

namespace egosieve::tools {
void ThreadsFlag::AddFlag(CLI::App& app) {
  app.add_option("-j,--threads", threads_,
                 "Threads on the host and on a CPU as device; 1: the stages do not overlap either; "
                 "0: $EGOSIEVE_THREADS, else the processors that affinity and "
                 "control groups allow. The output is the same")
      ->check(Between(0, kernels::kMostThreads))
      ->type_name("NUMBER");
}

int ThreadsFlag::Apply() const {
  if (threads_ > 0) kernels::SetMaximumThreads(threads_);
  const int threads = std::min(kernels::MaximumThreads(), kernels::kMostThreads);
  kernels::SetMaximumThreads(threads);
  cv::setNumThreads(threads);
  return threads;
}

}  // namespace egosieve::tools
