// One drive of a batch: segment in a process of its own, so that what happens to it stays there.
//
// It is started with --resume: a run that is whole is left as it is, half of one goes on, and a run
// with other flags is refused. What it says goes to egosieve_logs/OUT.log beside its run folder.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

struct DriveOutcome {
  enum class State { kDone, kWasDone, kFramesFailed, kFailed, kInterrupted, kNotStarted };
  State state = State::kNotStarted;
  int64_t frames_answered = 0;
  int64_t frames_failed = 0;
  double seconds = 0.0;  // of this batch
  std::string reason;    // the error's line, where it failed

  bool failed() const { return state == State::kFailed || state == State::kFramesFailed; }
};

const char* StateName(DriveOutcome::State state);

class DriveJob {
 public:
  // `program`: egosieve. Unavailable where no process can be had.
  static absl::StatusOr<DriveJob> Start(const std::string& program, const BatchEntry& entry);

  // Asks it to finish its frame and end.
  void Interrupt() const;
  // Whether it has ended; then outcome() tells how.
  bool HasEnded();
  const DriveOutcome& outcome() const { return outcome_; }

 private:
  DriveJob(const BatchEntry& entry, pid_t process, std::string finished_before)
      : entry_(entry), process_(process), finished_before_(std::move(finished_before)) {}

  void Judge(int exit_code);

  BatchEntry entry_;
  pid_t process_ = -1;
  std::string finished_before_;  // when the run in the folder had ended; empty where none had
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  DriveOutcome outcome_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_JOB_H_
