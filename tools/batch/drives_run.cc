#include "tools/batch/drives_run.h"

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/cli/warning.h"

namespace egosieve::tools {
namespace {

class DrivesRun {
 public:
  DrivesRun(const BatchPlan& plan, std::string program)
      : plan_(plan),
        program_(std::move(program)),
        tasks_(plan.tasks().size(), State::kWaiting),
        drives_(StatusOfAll(plan)) {}

  std::vector<DriveStatus> Run(int jobs) {
    std::vector<std::thread> others;
    try {
      for (int i = 1; i < jobs; ++i) others.emplace_back([this] { Work(); });
    } catch (const std::system_error&) {
      // Those that the system gives go on.
    }
    Work();
    for (std::thread& other : others) other.join();
    Warn(WritePage(plan_, drives_).message());
    return drives_;
  }

 private:
  enum class State { kWaiting, kRunning, kDone, kOver };  // kOver: failed or interrupted

  // Runs the first task that can begin, drive by drive; false if there is none now.
  bool RunNext(std::unique_lock<std::mutex>& lock) {
    for (size_t drive = 0; drive < drives_.size(); ++drive) {
      for (size_t stage = 0; stage < plan_.stages(); ++stage) {
        const size_t task = plan_.Number(stage, drive);
        const std::vector<size_t>& needs = plan_.tasks()[task].needs;
        if (tasks_[task] == State::kWaiting &&
            std::all_of(needs.begin(), needs.end(),
                        [&](size_t needed) { return tasks_[needed] == State::kDone; })) {
          RunTask(task, drive, lock);
          return true;
        }
      }
    }
    return false;
  }

  void Work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!InterruptionRequested()) {
      if (RunNext(lock)) {
        ended_.notify_all();
      } else if (std::count(tasks_.begin(), tasks_.end(), State::kRunning) > 0) {
        ended_.wait(lock);
      } else {
        break;
      }
    }
  }

  void RunTask(size_t task, size_t drive, std::unique_lock<std::mutex>& lock) {
    const std::string& stage = plan_.tasks()[task].stage;
    tasks_[task] = State::kRunning;
    lock.unlock();
    bool has_begun = false;  // a task that is done has no program
    const absl::StatusOr<int> code = plan_.Run(task, program_, /*to_log=*/true, [&] {
      const std::lock_guard<std::mutex> own(mutex_);
      if (!std::exchange(has_begun, true)) Say(drive, stage, "running");
      return InterruptionRequested();
    });
    DriveStatus now = StatusOf(plan_, drive);
    lock.lock();
    const bool is_good = code.ok() && TaskRecord{"", *code, 0.0, ""}.is_good();
    tasks_[task] = is_good ? State::kDone : State::kOver;
    if (!code.ok() && now.reason.empty()) {  // not even the book could be written
      now.state = "failed";
      now.exit_code = static_cast<int>(ExitCodeForStatus(code.status()));
      now.reason = std::string(code.status().message());
    }
    drives_[drive] = std::move(now);
    const char* end = is_good ? " done" : code.ok() && *code == 130 ? " interrupted" : " failed";
    if (has_begun || !is_good) Say(drive, stage + end, drives_[drive].state);
  }

  void Say(size_t drive, const std::string& what, const std::string& state) {
    std::cerr << absl::StrFormat("batch: %d of %d, %s: %s\n", drive + 1, drives_.size(),
                                 plan_.drives()[drive].out, what);
    drives_[drive].state = state;
    WritePage(plan_, drives_).IgnoreError();  // the last one tells
  }

  const BatchPlan& plan_;
  const std::string program_;
  std::mutex mutex_;  // of all below
  std::condition_variable ended_;
  std::vector<State> tasks_;  // by number
  std::vector<DriveStatus> drives_;
};

}  // namespace

std::vector<DriveStatus> RunDrives(const BatchPlan& plan, const std::string& program, int jobs) {
  setenv("EGOSIEVE_THREADS", absl::StrCat(std::max(1, kernels::MaximumThreads() / jobs)).c_str(),
         /*overwrite=*/1);  // for the tasks' programs
  return DrivesRun(plan, program).Run(jobs);
}

}  // namespace egosieve::tools
