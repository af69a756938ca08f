#include "tools/batch/drives_run.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <system_error>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "tools/cli/interruption.h"

namespace egosieve::tools {
namespace {

constexpr auto kPagePause = std::chrono::seconds(3);  // a page of many drives takes long

}  // namespace

DrivesRun::DrivesRun(const BatchPlan& plan, std::string program)
    : plan_(plan),
      program_(std::move(program)),
      tasks_(static_cast<size_t>(plan.task_count()), State::kWaiting),
      drives_(StatusOfAll(plan)) {}

void DrivesRun::Run(int jobs) {
  setenv("EGOSIEVE_THREADS", absl::StrCat(std::max(1, kernels::MaximumThreads() / jobs)).c_str(),
         /*overwrite=*/1);  // for the tasks' programs
  std::vector<std::thread> others;
  try {
    for (int i = 1; i < jobs; ++i) others.emplace_back([this] { Work(); });
  } catch (const std::system_error&) {
    // Those that the system gives go on.
  }
  Work();
  for (std::thread& other : others) other.join();
  page_due_ = {};
  WritePageIfDue();
}

int64_t DrivesRun::Next() const {
  for (size_t drive = 0; drive < plan_.entries().size(); ++drive) {
    for (size_t stage = 0; stage < plan_.stages().size(); ++stage) {
      const auto state = [&](size_t of) {
        return tasks_[static_cast<size_t>(plan_.TaskNumber(of, drive))];
      };
      const std::vector<size_t>& needs = plan_.stages()[stage].needs;
      if (state(stage) == State::kWaiting &&
          std::all_of(needs.begin(), needs.end(),
                      [&](size_t needed) { return state(needed) == State::kDone; })) {
        return plan_.TaskNumber(stage, drive);
      }
    }
  }
  return -1;
}

bool DrivesRun::AnyRuns() const {
  return std::count(tasks_.begin(), tasks_.end(), State::kRunning) > 0;
}

void DrivesRun::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!InterruptionRequested()) {
    const int64_t task = Next();
    if (task >= 0) {
      const size_t drives = plan_.entries().size(), number = static_cast<size_t>(task);
      RunTask(number / drives, number % drives, lock);
      ended_.notify_all();
    } else if (AnyRuns()) {
      ended_.wait(lock);
    } else {
      break;
    }
  }
}

void DrivesRun::RunTask(size_t stage, size_t drive, std::unique_lock<std::mutex>& lock) {
  State& task = tasks_[static_cast<size_t>(plan_.TaskNumber(stage, drive))];
  const std::string& name = plan_.stages()[stage].name;
  task = State::kRunning;
  lock.unlock();
  bool has_begun = false;
  const absl::StatusOr<int> code = plan_.Run(stage, drive, program_, /*to_log=*/true, [&] {
    const std::lock_guard<std::mutex> own(mutex_);
    drives_[drive].state = "running";
    if (!std::exchange(has_begun, true)) Say(drive, name);
    WritePageIfDue();
    return InterruptionRequested();
  });
  DriveStatus now = StatusOf(plan_, drive);
  lock.lock();
  const bool is_good = code.ok() && TaskRecord{"", *code, 0.0, ""}.is_good();
  task = is_good ? State::kDone : State::kOver;
  if (!code.ok() && now.reason.empty()) {  // not even the book could be written
    now.state = "failed";
    now.exit_code = static_cast<int>(ExitCodeForStatus(code.status()));
    now.reason = std::string(code.status().message());
  }
  drives_[drive] = std::move(now);
  if (has_begun || !is_good) {
    Say(drive, absl::StrCat(name, is_good                     ? " done"
                                  : code.ok() && *code == 130 ? " interrupted"
                                                              : " failed"));
  }
}

void DrivesRun::Say(size_t drive, const std::string& what) {
  std::cerr << absl::StrFormat("batch: %d of %d, %s: %s\n", drive + 1, drives_.size(),
                               plan_.entries()[drive].out, what);
  has_news_ = true;
}

void DrivesRun::WritePageIfDue() {
  const auto now = std::chrono::steady_clock::now();
  if (!has_news_ || now < page_due_) return;
  page_status_ = WritePage(plan_, drives_);
  has_news_ = false;
  page_due_ = now + kPagePause;
}

}  // namespace egosieve::tools
