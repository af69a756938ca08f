#include "tools/suite/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
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

std::vector<std::string> Environment(const std::map<std::string, std::string>& additions) {
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (additions.count(text.substr(0, text.find('='))) == 0) entries.push_back(text);
  }
  for (const auto& [name, value] : additions) entries.push_back(absl::StrCat(name, "=", value));
  return entries;
}

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

absl::StatusOr<int> RunChild(const ChildCommand& command,
                             const std::function<bool()>& stop_requested) {
  std::vector<std::string> arguments = command.arguments;
  std::vector<std::string> environment = Environment(command.environment);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (command.log_path.empty()) {
    posix_spawn_file_actions_adddup2(&actions, StderrDescriptor(), STDERR_FILENO);
  } else {
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, command.log_path.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  }
  pid_t process = 0;
  const int failure = posix_spawn(&process, arguments[0].c_str(), &actions, nullptr,
                                  Pointers(arguments).data(), Pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    return absl::UnavailableError(absl::StrCat(
        "cannot start ", arguments[0],
        command.log_path.empty() ? "" : absl::StrCat(" with its log in ", command.log_path), ": ",
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
