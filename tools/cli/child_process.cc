#include "tools/cli/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>

#include "absl/strings/str_cat.h"
#include "tools/cli/standard_streams.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(20);

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// The process of the command, or -1 with the reason in `failure`. vfork, since the parent has many
// threads and handlers of fork, such as OpenBLAS's. So the child shares the parent's memory until it
// executes, and calls only the system.
pid_t Start(char* const* arguments, const char* log_path, volatile int& failure) {
  const pid_t parent = getpid();
  const int error_descriptor = StderrDescriptor();
  failure = 0;
  const pid_t process = vfork();
  if (process < 0) failure = errno;
  if (process != 0) return process;
  signal(SIGTERM, SIG_DFL);  // not for the parent's handler, which only notes it
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);  // it ended before the call
  int output = error_descriptor;
  if (*log_path != 0) {
    output = open(log_path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (output >= 0) dup2(output, STDOUT_FILENO);
  }
  if (output >= 0 && dup2(output, STDERR_FILENO) >= 0) {
    execv(arguments[0], arguments);
  }
  failure = errno;
  _exit(1);
}

}  // namespace

absl::StatusOr<int> RunChild(std::vector<std::string> arguments, const std::string& log_path,
                             const std::function<bool()>& stop_requested) {
  volatile int failure = 0;
  const pid_t process = Start(Pointers(arguments).data(), log_path.c_str(), failure);
  if (failure != 0) {
    if (process > 0) waitpid(process, nullptr, 0);
    return absl::UnavailableError(
        absl::StrCat("cannot start ", arguments[0],
                     log_path.empty() ? "" : absl::StrCat(" with its log in ", log_path), ": ",
                     std::strerror(failure)));
  }
  bool stopping = false;
  while (true) {
    int status = 0;
    const pid_t ended = waitpid(process, &status, WNOHANG);
    if (ended == process) {
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    if (ended < 0 && errno != EINTR) {
      return absl::UnavailableError(
          absl::StrCat("lost ", arguments[0], ": ", std::strerror(errno)));
    }
    if (!stopping && stop_requested()) {
      stopping = true;
      kill(process, SIGTERM);  // a terminal sends SIGINT to the child, too: two would end it
    }
    std::this_thread::sleep_for(kPoll);
  }
}

absl::StatusOr<std::string> OwnProgram() {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot find this program's own file: ", error.message()));
  }
  return path.string();
}

}  // namespace egosieve::tools
