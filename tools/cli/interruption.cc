#include "tools/cli/interruption.h"

#include <atomic>
#include <csignal>

namespace egosieve::tools {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // safe in a signal handler

extern "C" void RequestInterruption(int /*signal*/) { requested.store(true); }

}  // namespace

void CatchInterruptions() {
  struct sigaction action = {};
  action.sa_handler = RequestInterruption;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool InterruptionRequested() { return requested.load(); }

}  // namespace egosieve::tools
