#include "tools/cli/threads_flag.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "kernels/base/parallel_for.h"
#include "tools/cli/checks.h"

namespace egosieve::tools {
namespace {

constexpr int kMost = 256;

}  // namespace

void ThreadsFlag::AddFlag(CLI::App& app) {
  app.add_option("--threads", threads_,
                 "Threads of the host, beside the device's; with 1 the stages do not overlap "
                 "either; 0: the machine's cores. The output is the same")
      ->check(Between(0, kMost))
      ->type_name("NUMBER");
}

int ThreadsFlag::Apply() const {
  const int threads =
      threads_ > 0 ? threads_
                   : std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMost);
  kernels::SetMaximumThreads(threads);
  cv::setNumThreads(threads);
  return threads;
}

}  // namespace egosieve::tools
