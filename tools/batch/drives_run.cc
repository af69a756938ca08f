#include "tools/batch/drives_run.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "tools/batch/index_page.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(50);
constexpr auto kPagePause = std::chrono::seconds(3);  // a page of many drives takes long

}  // namespace

void DrivesRun::Run(const std::string& program, int jobs) {
  setenv("EGOSIEVE_THREADS", absl::StrCat(std::max(1, kernels::MaximumThreads() / jobs)).c_str(),
         /*overwrite=*/1);             // for the drives' programs
  std::map<size_t, DriveJob> running;  // by entry
  size_t next = 0;
  bool interrupted = false;
  while (true) {
    if (InterruptionRequested() && !interrupted) {
      interrupted = true;
      for (auto& [i, job] : running) job.Interrupt();
    }
    while (!interrupted && next < entries_.size() && running.size() < static_cast<size_t>(jobs)) {
      const size_t i = next++;
      absl::StatusOr<DriveJob> job = DriveJob::Start(program, entries_[i]);
      if (job.ok()) {
        outcomes_[i] = job->outcome();
        running.emplace(i, *std::move(job));
        Say(i, "started");
      } else {
        outcomes_[i].state = DriveOutcome::State::kFailed;
        outcomes_[i].exit_code = static_cast<int>(ExitCodeForStatus(job.status()));
        outcomes_[i].reason = std::string(job.status().message());
        Say(i, "failed");
      }
    }
    if (running.empty()) break;
    if (std::chrono::steady_clock::now() >= page_due_) WritePage();
    std::this_thread::sleep_for(kPoll);
    for (auto job = running.begin(); job != running.end();) {
      const size_t i = job->first;
      const std::string before = outcomes_[i].command;
      const bool has_ended = job->second.HasEnded();
      outcomes_[i] = job->second.outcome();
      if (has_ended) {
        Say(i, StateName(outcomes_[i].state));
        job = running.erase(job);
        continue;
      }
      if (outcomes_[i].command != before) Say(i, outcomes_[i].command);
      ++job;
    }
  }
  WritePage();
}

void DrivesRun::Say(size_t i, const std::string& what) {
  std::cerr << absl::StrFormat("batch: %d of %d, %s: %s\n", i + 1, entries_.size(), entries_[i].out,
                               what);
  has_news_ = true;
}

void DrivesRun::WritePage() {
  if (!has_news_) return;
  index_status_ = WriteFileAtomically(index_, IndexPage(index_, entries_, outcomes_));
  has_news_ = false;
  page_due_ = std::chrono::steady_clock::now() + kPagePause;
}

void DrivesRun::Tell(const ResultFlag& result) const {
  size_t width = 3;
  for (const BatchEntry& entry : entries_) width = std::max(width, entry.out.size());
  const int column = static_cast<int>(width);
  std::string table = absl::StrFormat("%-*s  %-13s  %4s  %8s  %8s  %14s\n", column, "run", "state",
                                      "code", "answered", "failed", "time");
  nlohmann::ordered_json drives = nlohmann::ordered_json::array();
  for (size_t i = 0; i < entries_.size(); ++i) {
    const DriveOutcome& outcome = outcomes_[i];
    absl::StrAppendFormat(&table, "%-*s  %-13s  %4d  %8d  %8d  %14s", column, entries_[i].out,
                          StateName(outcome.state), outcome.exit_code, outcome.frames_answered,
                          outcome.frames_failed, DescribeDuration(outcome.seconds));
    absl::StrAppend(&table, outcome.reason.empty() ? "" : "  ", outcome.reason, "\n");
    drives.push_back({{"run", entries_[i].out},
                      {"state", StateName(outcome.state)},
                      {"exit_code", outcome.exit_code},
                      {"frames_answered", outcome.frames_answered},
                      {"frames_failed", outcome.frames_failed},
                      {"seconds", outcome.seconds},
                      {"reason", outcome.reason}});
  }
  absl::StrAppend(&table, "page of all drives: ", index_, "\n");
  result.Tell("batch", {{"drives", drives}, {"index", index_}}, table);
  if (!index_status_.ok()) Warn(index_status_.message());
}

bool DrivesRun::has_failed() const {
  return std::any_of(outcomes_.begin(), outcomes_.end(),
                     [](const DriveOutcome& outcome) { return outcome.failed(); });
}

}  // namespace egosieve::tools
