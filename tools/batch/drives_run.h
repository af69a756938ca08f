// Runs the tasks of a batch on this machine, several at the same time. Each task is a line on
// stderr; the page (status.h) is written anew every few seconds, and at the end.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/plan.h"
#include "tools/batch/status.h"

namespace egosieve::tools {

class DrivesRun {
 public:
  // program: egosieve.
  DrivesRun(const BatchPlan& plan, std::string program);

  // `jobs` tasks at the same time, which share the threads; a drive goes to its end before the next
  // begins, as far as its tasks leave programs free. Ends early if interrupted. A failing task ends
  // its drive and no other.
  void Run(int jobs);

  const std::vector<DriveStatus>& drives() const { return drives_; }
  // The last page that could not be written, which stops nothing.
  const absl::Status& page_status() const { return page_status_; }

 private:
  enum class State { kWaiting, kRunning, kDone, kOver };  // kOver: failed or interrupted

  void Work();
  // The number of a task that can begin; -1 if there is none now.
  int64_t Next() const;
  bool AnyRuns() const;
  void RunTask(size_t stage, size_t drive, std::unique_lock<std::mutex>& lock);
  void Say(size_t drive, const std::string& what);
  void WritePageIfDue();

  const BatchPlan& plan_;
  std::string program_;
  std::mutex mutex_;  // of all below
  std::condition_variable ended_;
  std::vector<State> tasks_;  // by number
  std::vector<DriveStatus> drives_;
  absl::Status page_status_;
  bool has_news_ = false;
  std::chrono::steady_clock::time_point page_due_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
