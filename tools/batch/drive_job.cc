#include "tools/batch/drive_job.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using State = DriveOutcome::State;

constexpr int kCannotStart = 126;  // as in shells

// The program's last line of error; earlier lines may be warnings.
std::string LastComplaint(const std::string& path) {
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (!text.ok()) return "";
  std::string last;
  for (absl::string_view line : absl::StrSplit(*text, '\n')) {
    if (absl::ConsumePrefix(&line, "egosieve: ")) last = std::string(line);
  }
  return last;
}

absl::StatusOr<RunDescription> DescriptionIn(const std::string& out) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(out));
  return folder.ReadDescription();
}

std::vector<std::string> Arguments(const std::string& program, const BatchEntry& entry,
                                   const BatchStep& step) {
  std::vector<std::string> words = {program, step.command, entry.out, "--progress=none"};
  if (step.command == "masks") {
    words.insert(words.end(), {absl::StrCat("--out=", MasksPath(entry)), "--overwrite"});
  }
  words.insert(words.end(), step.flags.begin(), step.flags.end());
  return words;
}

// Runs in the child: only calls that are safe after a fork. SIGTERM is blocked at the beginning.
[[noreturn]] void Become(pid_t batch, const sigset_t& signals, const char* program,
                         char* const* arguments, int log) {
  signal(SIGTERM, SIG_DFL);  // not for the batch's handler, which only notes it
  sigprocmask(SIG_SETMASK, &signals, nullptr);
  prctl(PR_SET_PDEATHSIG, SIGTERM);             // a batch that is killed also ends its drives
  if (getppid() != batch) _exit(kCannotStart);  // it was killed before that call
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(program, arguments);
  _exit(kCannotStart);
}

}  // namespace

const char* StateName(State state) {
  switch (state) {
    case State::kDone:
      return "done";
    case State::kWasDone:
      return "was done";
    case State::kFramesFailed:
      return "frames failed";
    case State::kFailed:
      return "failed";
    case State::kInterrupted:
      return "interrupted";
    case State::kNotStarted:
      return "not started";
    case State::kRunning:
      return "running";
  }
  return "";
}

absl::StatusOr<DriveJob> DriveJob::Start(const std::string& program, const BatchEntry& entry) {
  const std::string log_path = LogPath(entry);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(fs::path(log_path).parent_path().string()));
  std::error_code error;
  // The file is opened for appending next; that reports a log that cannot be removed.
  fs::remove(log_path, error);
  DriveJob job(program, entry);
  const absl::StatusOr<RunDescription> before = DescriptionIn(entry.out);
  if (before.ok() && before->ended == "done") job.finished_before_ = before->finished_utc;
  std::vector<std::string> words = {program,    "segment",
                                    entry.path, absl::StrCat("--out=", entry.out),
                                    "--resume", "--progress=none"};
  words.insert(words.end(), entry.flags.begin(), entry.flags.end());
  EGOSIEVE_RETURN_IF_ERROR(job.StartProcess(words));
  job.outcome_.state = State::kRunning;
  job.outcome_.command = "segment";
  return job;
}

absl::Status DriveJob::StartProcess(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = arguments;
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string log_path = LogPath(entry_);
  const int log =
      open(log_path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (log < 0) return kernels::WriteError(log_path, errno);
  const pid_t batch = getpid();
  sigset_t blocked, signals;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &signals);
  process_ = fork();
  if (process_ == 0) Become(batch, signals, program_.c_str(), pointers.data(), log);
  const int error = errno;
  pthread_sigmask(SIG_SETMASK, &signals, nullptr);
  close(log);
  if (process_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot start a process: ", std::strerror(error)));
  }
  return absl::OkStatus();
}

void DriveJob::Interrupt() {
  interrupted_ = true;
  if (process_ > 0) kill(process_, SIGTERM);
}

bool DriveJob::HasEnded() {
  if (process_ < 0) return true;
  int status = 0;
  const pid_t ended = waitpid(process_, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
  const int error = errno;
  process_ = -1;
  int exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (interrupted_ && exit_code == 128 + SIGTERM) {  // before the program caught signals
    exit_code = static_cast<int>(ExitCode::kInterrupted);
  }
  if (ended < 0) {
    outcome_.exit_code = static_cast<int>(ExitCode::kEnvironment);
    End(State::kFailed, absl::StrCat("cannot tell how ", outcome_.command, " ended: ",
                                     std::strerror(error), "; the same command does it again"));
  } else if (runs_segment_) {
    JudgeSegment(exit_code);
  } else {
    JudgeStep(exit_code);
  }
  if (outcome_.state == State::kRunning) {
    const absl::StatusOr<bool> goes_on = StartNext();
    if (!goes_on.ok()) {
      End(State::kFailed, std::string(goes_on.status().message()));
    } else if (*goes_on) {
      return false;
    }
  }
  outcome_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return true;
}

absl::StatusOr<bool> DriveJob::StartNext() {
  for (; next_step_ < entry_.then.size(); ++next_step_) {
    const BatchStep& step = entry_.then[next_step_];
    // Later steps depend on earlier ones.
    if (!did_something_ && IsStepDone(entry_, step, finished_)) continue;
    if (interrupted_) {
      End(State::kInterrupted, "");
      return false;
    }
    runs_segment_ = false;
    did_something_ = true;
    outcome_.command = step.command;
    EGOSIEVE_RETURN_IF_ERROR(StartProcess(Arguments(program_, entry_, step)));
    return true;
  }
  const bool is_whole = outcome_.frames_failed == 0 && outcome_.exit_code == 0;
  outcome_.state = !is_whole        ? State::kFramesFailed
                   : did_something_ ? State::kDone
                                    : State::kWasDone;
  outcome_.command.clear();
  return false;
}

void DriveJob::End(State state, const std::string& reason) {
  outcome_.state = state;
  outcome_.reason = reason;
}

void DriveJob::JudgeSegment(int exit_code) {
  const absl::StatusOr<RunDescription> after = DescriptionIn(entry_.out);
  if (after.ok()) {
    outcome_.frames_answered = after->frames_answered;
    outcome_.frames_failed = after->frames_failed;
    finished_ = after->finished_utc;
  }
  outcome_.exit_code = exit_code;
  const bool ended = after.ok() && after->ended == "done";
  if (exit_code == static_cast<int>(ExitCode::kInterrupted)) {
    End(State::kInterrupted, "");
  } else if (ended && exit_code == static_cast<int>(ExitCode::kFramesFailed)) {
    outcome_.reason = LastComplaint(LogPath(entry_));
  } else if (!ended || exit_code != 0) {
    const std::string complaint = LastComplaint(LogPath(entry_));
    End(State::kFailed, !complaint.empty() ? complaint
                        : exit_code > 128  ? absl::StrCat("ended by signal ", exit_code - 128)
                                           : absl::StrCat("ended with exit code ", exit_code));
  }
  did_something_ = finished_ != finished_before_;
}

void DriveJob::JudgeStep(int exit_code) {
  const BatchStep& step = entry_.then[next_step_++];
  if (exit_code == static_cast<int>(ExitCode::kInterrupted)) {
    outcome_.exit_code = exit_code;
    End(State::kInterrupted, "");
    return;
  }
  if (exit_code != 0 && exit_code != static_cast<int>(ExitCode::kFramesFailed)) {
    outcome_.exit_code = exit_code;
    const std::string complaint = LastComplaint(LogPath(entry_));
    End(State::kFailed,
        absl::StrCat(step.command, ": ",
                     complaint.empty() ? absl::StrCat("ended with ", exit_code) : complaint));
    return;
  }
  const absl::Status noted = NoteStepDone(entry_, step, finished_);
  if (!noted.ok()) End(State::kFailed, std::string(noted.message()));
}

}  // namespace egosieve::tools
