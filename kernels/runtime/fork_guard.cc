#include "kernels/runtime/fork_guard.h"

#include <unistd.h>

#include <atomic>

namespace egosieve::kernels {
namespace {

std::atomic<pid_t> first_user{0};

}  // namespace

absl::Status CheckNotForked() {
  const pid_t here = getpid();
  pid_t user = 0;
  if (first_user.compare_exchange_strong(user, here) || user == here) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "this process was forked from one that had used OpenCL, whose drivers do not survive that: "
      "start processes by spawn (in Python multiprocessing.get_context(\"spawn\")), fork before "
      "the first use, or use the device \"reference\" in both");
}

}  // namespace egosieve::kernels
