// Runs the program as a user does: a process of its own, its output and exit code kept.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace egosieve::tools {

struct ProgramOutcome {
  int code = -1;         // exit code, or 128 + the signal that ended it
  std::string out, err;  // stdout and stderr
};

// The binary under test, from the environment variable EGOSIEVE_PROGRAM or the test's runfiles.
std::string ProgramPath();

ProgramOutcome RunProgram(const std::vector<std::string>& arguments);
// The same of egosieve-eval, which lies in the runfiles of //tools/evaluate:sources.
ProgramOutcome RunEvaluation(const std::vector<std::string>& arguments);

// For tests that send signals: starts without waiting.
pid_t StartProgram(const std::vector<std::string>& arguments, const std::string& out_path,
                   const std::string& err_path);
int WaitForProgram(pid_t process);
// The same; kHung where it has not ended after so many seconds.
inline constexpr int kHung = -2;
int WaitForProgram(pid_t process, double seconds);

// What a command line of the shell prints.
std::string ShellOutput(const std::string& command);

// Whether the process has a handler for the signal.
bool Catches(pid_t process, int signal);

// Looks every millisecond, for a minute at most: a program may have crashed.
template <typename Condition>
bool WaitUntil(const Condition& condition) {
  for (int i = 0; i < 60000 && !condition(); ++i) usleep(1000);
  return condition();
}

inline std::vector<std::string> operator+(std::vector<std::string> words,
                                          const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// A named pipe that is full: a program whose output goes to it waits at its first write, so that it
// cannot end before a test has done what it wants to do.
class FullPipe {
 public:
  // Makes the pipe at `path`, where nothing may be, and fills it.
  explicit FullPipe(const std::string& path);
  ~FullPipe();
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;

  // Takes what is in the pipe, without waiting. What it was filled with is left out. From the first
  // call on the program goes on.
  std::string Empty();

 private:
  int descriptor_;
};

// What `text` has of lines, the last of which may lack its line break.
int CountLines(const std::string& text);

// The exit code, and one line that says `what`, and what to do.
void ExpectErrorLine(const ProgramOutcome& outcome, int code, const std::string& what);

}  // namespace egosieve::tools
