#include "tools/batch/batch_command.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drive_job.h"
#include "tools/batch/manifest.h"
#include "tools/batch/plan_run.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(50);

class BatchCommand : public Command {
 public:
  std::string name() const override { return "batch"; }
  std::string summary() const override {
    return "Segments a list of drives, here or as jobs of Slurm; does what is missing and ends "
           "with "
           "a table.";
  }
  std::string example() const override {
    return "egosieve batch drives.toml --jobs=2\n"
           "egosieve batch drives.toml --engine=slurm --shards=4 && egosieve batch drives.toml "
           "--status\n"
           "  # drives.toml: a table a drive, [a] with path = \"a.mp4\", out = \"out/a\" and\n"
           "  # segment's flags; or JSON, a list of {\"path\": ..., \"out\": ..., \"flags\": "
           "{...}}";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("MANIFEST", manifest_, "The drives, as JSON or TOML")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--jobs", jobs_, "Drives at the same time")
        ->check(Between(1, 256))
        ->type_name("NUMBER");
    plan_run_.AddFlags(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<BatchEntry> entries, ReadManifest(manifest_));
    if (plan_run_.IsAskedFor()) return plan_run_.Run(manifest_, entries, result_);
    std::error_code error;
    const std::string program = std::filesystem::read_symlink("/proc/self/exe", error).string();
    if (error) {
      return absl::UnavailableError("cannot find this program in /proc/self/exe; mount /proc");
    }
    const std::vector<DriveOutcome> outcomes = RunAll(program, entries);
    Tell(entries, outcomes);
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; the same command goes on");
    }
    return std::any_of(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.failed(); })
               ? ExitCode::kFramesFailed
               : ExitCode::kDone;
  }

 private:
  std::vector<DriveOutcome> RunAll(const std::string& program,
                                   const std::vector<BatchEntry>& entries) const {
    std::vector<DriveOutcome> outcomes(entries.size());
    std::map<size_t, DriveJob> running;  // by entry
    size_t next = 0;
    bool interrupted = false;
    while (true) {
      if (InterruptionRequested() && !interrupted) {
        interrupted = true;
        for (const auto& [i, job] : running) job.Interrupt();
      }
      while (!interrupted && next < entries.size() && running.size() < static_cast<size_t>(jobs_)) {
        const size_t i = next++;
        absl::StatusOr<DriveJob> job = DriveJob::Start(program, entries[i]);
        if (job.ok()) {
          running.emplace(i, *std::move(job));
          Say(i, entries, "started");
        } else {
          outcomes[i].state = DriveOutcome::State::kFailed;
          outcomes[i].reason = std::string(job.status().message());
          Say(i, entries, "failed");
        }
      }
      if (running.empty()) return outcomes;
      std::this_thread::sleep_for(kPoll);
      for (auto job = running.begin(); job != running.end();) {
        if (!job->second.HasEnded()) {
          ++job;
          continue;
        }
        outcomes[job->first] = job->second.outcome();
        Say(job->first, entries, StateName(outcomes[job->first].state));
        job = running.erase(job);
      }
    }
  }

  static void Say(size_t i, const std::vector<BatchEntry>& entries, const std::string& what) {
    std::cerr << absl::StrFormat("batch: %d of %d, %s: %s\n", i + 1, entries.size(), entries[i].out,
                                 what);
  }

  void Tell(const std::vector<BatchEntry>& entries,
            const std::vector<DriveOutcome>& outcomes) const {
    size_t width = 3;
    for (const BatchEntry& entry : entries) width = std::max(width, entry.out.size());
    const int column = static_cast<int>(width);
    std::string table = absl::StrFormat("%-*s  %-13s  %8s  %8s  %14s\n", column, "run", "state",
                                        "answered", "failed", "time");
    nlohmann::ordered_json drives = nlohmann::ordered_json::array();
    for (size_t i = 0; i < entries.size(); ++i) {
      const DriveOutcome& outcome = outcomes[i];
      absl::StrAppendFormat(&table, "%-*s  %-13s  %8d  %8d  %14s", column, entries[i].out,
                            StateName(outcome.state), outcome.frames_answered,
                            outcome.frames_failed, DescribeDuration(outcome.seconds));
      absl::StrAppend(&table, outcome.reason.empty() ? "" : "  ", outcome.reason, "\n");
      drives.push_back({{"run", entries[i].out},
                        {"state", StateName(outcome.state)},
                        {"frames_answered", outcome.frames_answered},
                        {"frames_failed", outcome.frames_failed},
                        {"seconds", outcome.seconds},
                        {"reason", outcome.reason}});
    }
    result_.Tell(name(), {{"drives", drives}}, table);
  }

  std::string manifest_;
  int jobs_ = 1;
  PlanRun plan_run_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeBatchCommand() { return std::make_unique<BatchCommand>(); }

}  // namespace egosieve::tools
