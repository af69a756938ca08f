#include "tests/tools/testing/program.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

#include "gmock/gmock.h"

namespace egosieve::tools {
namespace {

std::string Contents(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

void Redirect(const std::string& path, int descriptor) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0 || dup2(file, descriptor) < 0) _exit(125);
  close(file);
}

pid_t Start(const std::string& program, const std::vector<std::string>& arguments,
            const std::string& out_path, const std::string& err_path) {
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t process = fork();
  if (process == 0) {
    Redirect(out_path, STDOUT_FILENO);
    Redirect(err_path, STDERR_FILENO);
    execv(program.c_str(), argv.data());
    _exit(126);
  }
  return process;
}

ProgramOutcome Run(const std::string& program, const std::vector<std::string>& arguments) {
  const std::string out = testing::TempDir() + "/program.out";
  const std::string err = testing::TempDir() + "/program.err";
  return {.code = WaitForProgram(Start(program, arguments, out, err)),
          .out = Contents(out),
          .err = Contents(err)};
}

}  // namespace

std::string ProgramPath() {
  const char* path = std::getenv("EGOSIEVE_PROGRAM");
  return path != nullptr ? path : "tools/egosieve";
}

pid_t StartProgram(const std::vector<std::string>& arguments, const std::string& out_path,
                   const std::string& err_path) {
  return Start(ProgramPath(), arguments, out_path, err_path);
}

int WaitForProgram(pid_t process) {
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int WaitForProgram(pid_t process, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  siginfo_t ended = {};
  do {
    // Leaves it to be waited for.
    if (waitid(P_PID, process, &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0) {
      return WaitForProgram(process);
    }
    usleep(1000);
  } while (std::chrono::steady_clock::now() < end);
  return kHung;
}

std::string ShellOutput(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  char buffer[4096];
  while (pipe != nullptr && fgets(buffer, sizeof buffer, pipe.get()) != nullptr) output += buffer;
  return output;
}

ProgramOutcome RunProgram(const std::vector<std::string>& arguments) {
  return Run(ProgramPath(), arguments);
}

ProgramOutcome RunEvaluation(const std::vector<std::string>& arguments) {
  const std::string program = ProgramPath();
  setenv("EGOSIEVE_PROGRAM", program.c_str(), 1);
  return Run("tools/evaluate/egosieve-eval", arguments);
}

bool Catches(pid_t process, int signal) {
  const std::string status = Contents("/proc/" + std::to_string(process) + "/status");
  const size_t place = status.find("SigCgt:");
  return place != std::string::npos &&
         (std::stoull(status.substr(place + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

int CountLines(const std::string& text) {
  const int breaks = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  return breaks + (!text.empty() && text.back() != '\n');
}

// Both ends, so that it opens without waiting and no write finds it without a reader.
FullPipe::FullPipe(const std::string& path)
    : descriptor_(mkfifo(path.c_str(), 0600) == 0
                      ? open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)
                      : -1) {
  EXPECT_GE(descriptor_, 0) << path;
  constexpr std::array<char, PIPE_BUF> kZeros{};
  while (write(descriptor_, kZeros.data(), kZeros.size()) > 0) {
  }
}

FullPipe::~FullPipe() { close(descriptor_); }

std::string FullPipe::Empty() {
  std::string text;
  std::array<char, PIPE_BUF> part;
  ssize_t bytes = 0;
  while ((bytes = read(descriptor_, part.data(), part.size())) > 0) {
    text.append(part.data(), static_cast<size_t>(bytes));
  }
  std::erase(text, '\0');
  return text;
}

void ExpectErrorLine(const ProgramOutcome& outcome, int code, const std::string& what) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  EXPECT_THAT(outcome.err, testing::StartsWith("egosieve: "));
  EXPECT_THAT(outcome.err, testing::HasSubstr("; ")) << "it does not say what to do";
  EXPECT_THAT(outcome.err, testing::HasSubstr(what));
}

}  // namespace egosieve::tools
