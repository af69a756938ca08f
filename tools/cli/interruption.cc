#include "tools/cli/interruption.h"

#include <atomic>
#include <csignal>

namespace egosieve::tools {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // safe in a signal handler

extern "C" void RequestInterruption(int /*signal*/) { requested.store(true); }

sigset_t Signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

}  // namespace

void HoldInterruptions() {
  const sigset_t signals = Signals();
  sigprocmask(SIG_BLOCK, &signals, nullptr);
}

void EndOnInterruptions() {
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
  if (InterruptionRequested()) raise(SIGTERM);
}

void CatchInterruptions() {
  struct sigaction action = {};
  action.sa_handler = RequestInterruption;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const sigset_t signals = Signals();
  sigprocmask(SIG_UNBLOCK, &signals, nullptr);
}

bool InterruptionRequested() { return requested.load(); }

bool IsInterruption(const absl::Status& status) {
  return InterruptionRequested() && absl::IsInternal(status);
}

}  // namespace egosieve::tools
