#include "tools/batch/batch_command.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
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
#include "absl/strings/str_join.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drive_job.h"
#include "tools/batch/found_drives.h"
#include "tools/batch/index_page.h"
#include "tools/batch/manifest.h"
#include "tools/batch/plan_run.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/suite/child_process.h"
#include "vision/frame/input_files.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(50);

bool IsManifest(const std::string& input) {
  std::error_code error;
  const std::string extension = std::filesystem::path(input).extension().string();
  return extension == ".toml" || extension == ".json" ||
         (std::filesystem::is_regular_file(input, error) && !vision::HasVideoExtension(input));
}

class BatchCommand : public Command {
 public:
  std::string name() const override { return "batch"; }
  std::string summary() const override {
    return "Segments many drives and runs further commands on them, here or as jobs of Slurm; does "
           "what is missing, ends with a table and a page.";
  }
  std::string example() const override {
    return "egosieve batch videos --out=out --jobs=2 --then=reconstruct,masks,render,report\n"
           "egosieve batch 'videos/*.mp4' --out=out --segment_flags='--profile=fast --stride=3'\n"
           "egosieve batch drives.toml --engine=slurm --shards=4 && egosieve batch drives.toml "
           "--status\n"
           "  # [defaults] with out = \"out\", then = [\"reconstruct\", \"masks\"] and segment's "
           "flags,\n"
           "  # [defaults.masks] with those of masks; then a table per drive, [a] with path = "
           "\"a.mp4\";\n"
           "  # or JSON, a list of {\"path\": ..., \"out\": ..., \"flags\": {...}}";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", inputs_,
                   "A folder or a glob of drives (videos, and folders of pictures or videos), or a "
                   "manifest, as JSON or TOML")
        ->required()
        ->default_str("")
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", given_.out,
                   "The folder for the run folders, which go by the drives' names; of a manifest "
                   "for drives that name none")
        ->type_name("DIR");
    app.add_option("--jobs", jobs_, "Drives at the same time, which share the threads")
        ->check(Between(1, 256))
        ->type_name("NUMBER");
    plan_run_.AddFlags(app);
    app.add_option("--then", then_,
                   absl::StrCat("What follows segment, by commas: ",
                                absl::StrJoin(FollowingCommands(), ", "),
                                "; masks go to OUT/NAME.masks. What has been done on the same run "
                                "with the same flags is left"))
        ->type_name("COMMANDS");
    app.add_option("--segment_flags", segment_flags_, "Flags of segment for all drives, in quotes")
        ->type_name("FLAGS");
    app.add_option("--masks_flags", masks_flags_,
                   "Flags of masks for all drives, in quotes: '--for=colmap --dilate=10'; those of "
                   "other commands go into a manifest")
        ->type_name("FLAGS");
    app.add_option("--index", index_,
                   "The page of all drives, written as they go on; default: batch.html in the "
                   "folder that all run folders share")
        ->type_name("FILE");
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(entries_, FindEntries());
    if (plan_run_.IsAskedFor()) return RunPlan();
    EGOSIEVE_RETURN_IF_ERROR(plan_run_.CheckUncut(entries_));
    if (index_.empty()) index_ = DefaultIndexPath(entries_);
    EGOSIEVE_RETURN_IF_ERROR(CheckIndexPath(index_));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string program, OwnProgram());
    if (!left_out_.empty()) {
      Warn(absl::StrCat("no drives, and left out: ", absl::StrJoin(left_out_, ", ")));
    }
    RunAll(program);
    Tell();
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; the same command goes on");
    }
    return std::any_of(outcomes_.begin(), outcomes_.end(), [](const auto& o) { return o.failed(); })
               ? ExitCode::kFramesFailed
               : ExitCode::kDone;
  }

 private:
  // Runs the plan outside this process (plan_run.h).
  absl::StatusOr<ExitCode> RunPlan() const {
    if (inputs_.size() > 1) {
      return absl::InvalidArgumentError(
          "--engine, --task, --plan and --status take one INPUT; list the drives in a manifest");
    }
    // Files for the engine are written beside this path.
    const std::string& beside = IsManifest(inputs_.front()) ? inputs_.front() : given_.out;
    return plan_run_.Run(beside, entries_, result_);
  }

  absl::StatusOr<std::vector<BatchEntry>> FindEntries() {
    if (!then_.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(given_.then, ParseThen(then_));
      given_.says_then = true;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(given_.flags["segment"], ParseFlags(segment_flags_));
    EGOSIEVE_ASSIGN_OR_RETURN(given_.flags["masks"], ParseFlags(masks_flags_));
    std::vector<BatchEntry> entries;
    for (const std::string& input : inputs_) {
      if (IsManifest(input)) {
        EGOSIEVE_ASSIGN_OR_RETURN(std::vector<BatchEntry> listed, ReadManifest(input, given_));
        entries.insert(entries.end(), listed.begin(), listed.end());
        continue;
      }
      if (given_.out.empty()) {
        return absl::InvalidArgumentError("--out is missing; give the folder for the run folders");
      }
      EGOSIEVE_ASSIGN_OR_RETURN(const FoundDrives found, FindDrives(input));
      for (const FoundDrive& drive : found.drives) {
        entries.push_back(MakeEntry(drive.name, drive.path, given_));
      }
      left_out_.insert(left_out_.end(), found.left_out.begin(), found.left_out.end());
    }
    EGOSIEVE_RETURN_IF_ERROR(CheckFolders(entries));
    return entries;
  }

  void RunAll(const std::string& program) {
    outcomes_.assign(entries_.size(), DriveOutcome());
    setenv("EGOSIEVE_THREADS", absl::StrCat(std::max(1, kernels::MaximumThreads() / jobs_)).c_str(),
           /*overwrite=*/1);             // for the drives' programs
    std::map<size_t, DriveJob> running;  // by entry
    size_t next = 0;
    bool interrupted = false;
    while (true) {
      if (InterruptionRequested() && !interrupted) {
        interrupted = true;
        for (auto& [i, job] : running) job.Interrupt();
      }
      while (!interrupted && next < entries_.size() &&
             running.size() < static_cast<size_t>(jobs_)) {
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
      if (running.empty()) return;
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
  }

  // A page that cannot be written does not stop the drives; the last failure is reported.
  void Say(size_t i, const std::string& what) {
    std::cerr << absl::StrFormat("batch: %d of %d, %s: %s\n", i + 1, entries_.size(),
                                 entries_[i].out, what);
    index_status_ = WriteFileAtomically(index_, IndexPage(index_, entries_, outcomes_));
  }

  void Tell() const {
    size_t width = 3;
    for (const BatchEntry& entry : entries_) width = std::max(width, entry.out.size());
    const int column = static_cast<int>(width);
    std::string table = absl::StrFormat("%-*s  %-13s  %4s  %8s  %8s  %14s\n", column, "run",
                                        "state", "code", "answered", "failed", "time");
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
    result_.Tell(name(), {{"drives", drives}, {"index", index_}}, table);
    if (!index_status_.ok()) Warn(index_status_.message());
  }

  std::vector<std::string> inputs_;
  std::string then_, segment_flags_, masks_flags_, index_;
  BatchSettings given_;
  int jobs_ = 1;
  PlanRun plan_run_;
  ResultFlag result_;

  std::vector<BatchEntry> entries_;
  std::vector<std::string> left_out_;  // the inputs that are not drives
  std::vector<DriveOutcome> outcomes_;
  absl::Status index_status_;
};

}  // namespace

std::unique_ptr<Command> MakeBatchCommand() { return std::make_unique<BatchCommand>(); }

}  // namespace egosieve::tools
