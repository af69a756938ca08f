// One drive of a batch: segment and the commands that follow it. Each runs in a process of its own,
// so that a failure affects no other drive.
//
// segment is started with --resume: a complete run stays as it is, a partial run is continued, and
// a run with other flags is refused. A following command runs unless it was already done on this
// run with these flags; masks go to OUT.masks. The output of all goes to the drive's log, and what
// is done into its notes (drive_files.h).
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/drive_files.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

struct DriveOutcome {
  enum class State { kDone, kWasDone, kFramesFailed, kFailed, kInterrupted, kNotStarted, kRunning };
  State state = State::kNotStarted;
  std::string command;  // the command that runs or has failed
  int exit_code = 0;    // of this command, else of segment
  int64_t frames_answered = 0;
  int64_t frames_failed = 0;
  double seconds = 0.0;  // spent in this batch
  std::string reason;    // the error's line, if it failed

  bool failed() const { return state == State::kFailed || state == State::kFramesFailed; }
};

const char* StateName(DriveOutcome::State state);

class DriveJob {
 public:
  // `program`: egosieve. Unavailable if no process can be started.
  static absl::StatusOr<DriveJob> Start(const std::string& program, const BatchEntry& entry);

  // Asks the process to finish its frame and end.
  void Interrupt();
  // Whether the job has ended; if not, outcome() names the running command.
  bool HasEnded();
  const DriveOutcome& outcome() const { return outcome_; }

 private:
  DriveJob(std::string program, const BatchEntry& entry)
      : program_(std::move(program)), entry_(entry) {}

  absl::Status StartProcess(const std::vector<std::string>& arguments);
  // Starts the next command that is not done; false if there is none.
  absl::StatusOr<bool> StartNext();
  void End(DriveOutcome::State state, const std::string& reason);
  void JudgeSegment(int exit_code);
  void JudgeStep(int exit_code);

  std::string program_;
  BatchEntry entry_;
  pid_t process_ = -1;
  std::string finished_before_;  // when the run found in the folder had ended; empty without one
  std::string finished_;         // the same for the present run
  size_t next_step_ = 0;         // of entry_.then
  bool runs_segment_ = true;
  bool did_something_ = false;
  bool interrupted_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  DriveOutcome outcome_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
