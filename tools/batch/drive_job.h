// One drive of a batch: segment and what follows it, each in a process of its own, so that what
// happens to it stays there.
//
// segment is started with --resume: a whole run stays as it is, half of one is continued, and
// a run with other flags is refused. What follows is done where it has not been done with these
// flags on this run; masks go to OUT.masks. What they say goes to egosieve_logs/OUT.log beside the
// run folder, and what has been done is noted in egosieve_logs/OUT.then.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

struct DriveOutcome {
  enum class State { kDone, kWasDone, kFramesFailed, kFailed, kInterrupted, kNotStarted, kRunning };
  State state = State::kNotStarted;
  std::string command;  // that runs, or that failed
  int exit_code = 0;    // of that, else of segment
  int64_t frames_answered = 0;
  int64_t frames_failed = 0;
  double seconds = 0.0;  // of this batch
  std::string reason;    // the error's line, where it failed

  bool failed() const { return state == State::kFailed || state == State::kFramesFailed; }
};

const char* StateName(DriveOutcome::State state);

// Where the drive's log lies, the notes of what engines have done (plan.h), and its masks.
std::string LogPath(const BatchEntry& entry);
std::string TaskNotesPath(const BatchEntry& entry);
std::string MasksPath(const BatchEntry& entry);

class DriveJob {
 public:
  // `program`: egosieve. Unavailable where no process can be had.
  static absl::StatusOr<DriveJob> Start(const std::string& program, const BatchEntry& entry);

  // Asks it to finish its frame and end.
  void Interrupt();
  // Whether it has ended; else outcome() says what runs.
  bool HasEnded();
  const DriveOutcome& outcome() const { return outcome_; }

 private:
  DriveJob(std::string program, const BatchEntry& entry)
      : program_(std::move(program)), entry_(entry) {}

  absl::Status StartProcess(const std::vector<std::string>& arguments);
  // The next command that has not been done; false where there is none.
  absl::StatusOr<bool> StartNext();
  void End(DriveOutcome::State state, const std::string& reason);
  void JudgeSegment(int exit_code);
  void JudgeStep(int exit_code);
  // What is noted of a step that has been done.
  std::string Note(const BatchStep& step) const;
  bool IsDone(const BatchStep& step) const;

  std::string program_;
  BatchEntry entry_;
  pid_t process_ = -1;
  std::string finished_before_;  // when the run in the folder had ended; empty where none had
  std::string finished_;         // likewise, now
  size_t next_step_ = 0;         // of entry_.then
  bool runs_segment_ = true;
  bool did_something_ = false;
  bool interrupted_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  DriveOutcome outcome_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
