#include "tools/batch/drive_job.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

constexpr int kCannotStart = 126;  // as shells have it

// In a folder of this name beside the run folder, so that no file of somebody else's is in the way.
std::string LogPath(const BatchEntry& entry) {
  const std::filesystem::path out = AbsolutePath(entry.out);
  return (out.parent_path() / "egosieve_logs" / out.filename()).string() + ".log";
}

// The last line that the program says about an error; what comes before may be warnings.
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

// In the child: only calls that are safe after a fork.
[[noreturn]] void Become(const char* program, char* const* arguments, int log) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // a batch that is killed takes its drives along
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(program, arguments);
  _exit(kCannotStart);
}

}  // namespace

const char* StateName(DriveOutcome::State state) {
  switch (state) {
    case DriveOutcome::State::kDone:
      return "done";
    case DriveOutcome::State::kWasDone:
      return "was done";
    case DriveOutcome::State::kFramesFailed:
      return "frames failed";
    case DriveOutcome::State::kFailed:
      return "failed";
    case DriveOutcome::State::kInterrupted:
      return "interrupted";
    case DriveOutcome::State::kNotStarted:
      return "not started";
  }
  return "";
}

absl::StatusOr<DriveJob> DriveJob::Start(const std::string& program, const BatchEntry& entry) {
  const std::string log_path = LogPath(entry);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(std::filesystem::path(log_path).parent_path().string()));
  std::vector<std::string> words = {program,    "segment",
                                    entry.path, absl::StrCat("--out=", entry.out),
                                    "--resume", "--progress=none"};
  words.insert(words.end(), entry.flags.begin(), entry.flags.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const absl::StatusOr<RunDescription> before = DescriptionIn(entry.out);
  const int log =
      open(log_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (log < 0) return kernels::WriteError(log_path, errno);
  const pid_t process = fork();
  if (process == 0) Become(program.c_str(), arguments.data(), log);
  const int error = errno;
  close(log);
  if (process < 0) {
    return absl::UnavailableError(absl::StrCat("cannot start a process: ", std::strerror(error)));
  }
  return DriveJob(entry, process,
                  before.ok() && before->ended == "done" ? before->finished_utc : "");
}

void DriveJob::Interrupt() const {
  if (process_ > 0) kill(process_, SIGTERM);
}

bool DriveJob::HasEnded() {
  if (process_ < 0) return true;
  int status = 0;
  const pid_t ended = waitpid(process_, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
  process_ = -1;
  outcome_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  Judge(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
  return true;
}

void DriveJob::Judge(int exit_code) {
  using State = DriveOutcome::State;
  const absl::StatusOr<RunDescription> after = DescriptionIn(entry_.out);
  if (after.ok()) {
    outcome_.frames_answered = after->frames_answered;
    outcome_.frames_failed = after->frames_failed;
  }
  const bool ended = after.ok() && after->ended == "done";
  if (exit_code == static_cast<int>(ExitCode::kInterrupted)) {
    outcome_.state = State::kInterrupted;
  } else if (ended && (exit_code == static_cast<int>(ExitCode::kFramesFailed) ||
                       (exit_code == 0 && after->frames_failed > 0))) {
    outcome_.state = State::kFramesFailed;
    outcome_.reason = LastComplaint(LogPath(entry_));
  } else if (ended && exit_code == 0) {
    outcome_.state = after->finished_utc == finished_before_ ? State::kWasDone : State::kDone;
  } else {
    outcome_.state = State::kFailed;
    outcome_.reason = LastComplaint(LogPath(entry_));
    if (outcome_.reason.empty()) {
      outcome_.reason = exit_code > 128 ? absl::StrCat("ended by signal ", exit_code - 128)
                                        : absl::StrCat("ended with exit code ", exit_code);
    }
  }
}

}  // namespace egosieve::tools
