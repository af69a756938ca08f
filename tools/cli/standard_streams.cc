#include "tools/cli/standard_streams.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <ext/stdio_filebuf.h>
#include <iostream>
#include <string>

#include "absl/strings/str_cat.h"
#include "kernels/base/exception_status.h"
#include "kernels/runtime/driver_check.h"
#include "tools/cli/exit_code.h"

namespace egosieve::tools {
namespace {

constexpr int kLinesTold = 3;  // number of a library's last lines in the report
constexpr int kLowest = 10;    // lower descriptors are left to the user's shell

int own_stderr = STDERR_FILENO;
int library_lines = -1;           // reading end of the pipe
std::array<char, 1 << 16> words;  // contents of the pipe, at the end
std::array<char, 1024> advice;    // prepared beforehand: a signal handler cannot allocate

bool UserWantsLibraryLines() {
  for (const char* name :
       {"EGOSIEVE_LIBRARY_LINES", "OPENCV_LOG_LEVEL", "OPENCV_FFMPEG_LOGLEVEL", "POCL_DEBUG"}) {
    if (std::getenv(name) != nullptr) return true;
  }
  return false;
}

void OpenMissingDescriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) >= 0) continue;
    // The lowest free number is this one.
    [[maybe_unused]] const int opened =
        open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void Say(const char* text, size_t size) {
  [[maybe_unused]] const ssize_t written = write(own_stderr, text, size);
}
void Say(const char* text) { Say(text, std::strlen(text)); }

// Start of the last lines; replaces line breaks by spaces.
const char* LastWords() {
  size_t size = 0;
  ssize_t count;
  while (size + 1 < words.size() &&
         (count = read(library_lines, words.data() + size, words.size() - 1 - size)) > 0) {
    size += static_cast<size_t>(count);
  }
  while (size > 0 && (words[size - 1] == '\n' || words[size - 1] == ' ')) --size;
  words[size] = '\0';
  size_t begin = size;
  for (int breaks = 0; begin > 0; --begin) {
    char& before = words[begin - 1];
    if (before == '\n' && ++breaks == kLinesTold) break;
    if (before == '\n' || before == '\r') before = ' ';
  }
  return words.data() + begin;
}

void TellOfAbort(int signal) {
  const char* last = LastWords();
  Say("egosieve: a library ended the program");
  if (signal != SIGABRT)
    Say(", or a fault of its own did, by reaching for memory that is not there");
  if (*last != '\0') {
    Say(": ");
    Say(last);
  }
  Say(advice.data());
}

// An abort is a library's refusal of the environment. A fault of memory ends the program by its
// signal, with the core that the system then makes.
extern "C" void CatchFault(int signal) {
  TellOfAbort(signal);
  if (signal == SIGABRT) _exit(static_cast<int>(ExitCode::kEnvironment));
  raise(signal);  // comes on return, and the action is the default one by then
}

[[noreturn]] void TellOfException() {
  if (std::current_exception() == nullptr) std::abort();
  std::string line;
  try {
    throw;
  } catch (...) {
    line = absl::StrCat(ErrorLine(kernels::CurrentExceptionStatus().message()), "\n");
  }
  Say(line.data(), line.size());
  _exit(static_cast<int>(ExitCode::kEnvironment));
}

}  // namespace
}  // namespace egosieve::tools

// Replaces the C library's abort, also for libraries: one that loads LLVM has LLVM's handler of
// SIGABRT in place before WatchForAborts is called again.
extern "C" void abort() noexcept {
  if (egosieve::tools::own_stderr != STDERR_FILENO) egosieve::tools::CatchFault(SIGABRT);
  signal(SIGABRT, SIG_DFL);
  raise(SIGABRT);
  _exit(128 + SIGABRT);
}

namespace egosieve::tools {

void TakeStandardStreams() {
  OpenMissingDescriptors();
  if (UserWantsLibraryLines()) return;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return;
  const int own = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, kLowest);
  library_lines = fcntl(ends[0], F_DUPFD_CLOEXEC, kLowest);
  if (own >= 0 && library_lines >= 0 && dup2(ends[1], STDERR_FILENO) >= 0) {
    own_stderr = own;
    static __gnu_cxx::stdio_filebuf<char> buffer(own, std::ios::out);
    std::cerr.rdbuf(&buffer);
    const std::string text = absl::StrCat(
        "; allow it more memory and threads (see ulimit -v, ulimit -u), and where it comes again, "
        "delete the folder ",
        kernels::PoclCacheFolder(), ", which PoCL fills with compiled kernels\n");
    std::strncpy(advice.data(), text.c_str(), advice.size() - 1);
    WatchForAborts();
    std::set_terminate(TellOfException);
  }
  close(ends[0]);
  close(ends[1]);
}

void WatchForAborts() {
  if (own_stderr == STDERR_FILENO) return;
  struct sigaction action = {};
  action.sa_handler = CatchFault;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS}) sigaction(signal, &action, nullptr);
}

int StderrDescriptor() { return own_stderr; }

}  // namespace egosieve::tools
