#include "tools/batch/plan_run.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/slurm.h"
#include "tools/batch/task_cost.h"
#include "tools/cli/checks.h"
#include "tools/cli/child_process.h"
#include "tools/cli/given_flags.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

std::string JobsFolder(const std::string& manifest) {
  const fs::path path = AbsolutePath(manifest);
  return (path.parent_path() / "egosieve_jobs" / path.stem()).string();
}

std::string MapsText(const DriveProgress& progress) {
  return absl::StrCat(progress.maps, " of ", progress.frames - progress.frames_failed);
}

size_t WidestRun(const BatchPlan& plan) {
  size_t width = 3;
  for (const BatchEntry& entry : plan.entries()) {
    const int pieces = static_cast<int>(entry.cuts.size()) + 1;
    width = std::max(width, PieceFolder(entry, pieces).size());
  }
  return width;
}

DriveProgress ProgressOf(const std::string& run) {
  absl::StatusOr<DriveProgress> read = ReadDriveProgress(run);
  if (read.ok()) return *std::move(read);
  DriveProgress progress;
  progress.state = "unreadable";
  progress.reason = std::string(read.status().message());
  return progress;
}

std::string StatusRow(const std::string& run, int width, const DriveProgress& progress) {
  const std::string row =
      absl::StrFormat("%-*s  %-11s  %8d  %8d  %17s  %-11s  %s", width, run, progress.state,
                      progress.frames, progress.frames_failed, MapsText(progress),
                      progress.is_reconstructed ? "done" : "-", progress.has_report ? "done" : "-");
  return progress.reason.empty() ? row : absl::StrCat(row, "  ", progress.reason);
}

// Paths in the plan must be valid in any folder.
std::vector<BatchEntry> WithAbsolutePaths(std::vector<BatchEntry> entries) {
  for (BatchEntry& entry : entries) {
    entry.path = AbsolutePath(entry.path);
    entry.out = AbsolutePath(entry.out);
  }
  return entries;
}

}  // namespace

void PlanRun::AddFlags(CLI::App& app) {
  app.add_option(
         "--engine", engine_,
         "local: segments here; slurm: submits segment and what follows, reconstruct and report "
         "where nothing else is said, as job arrays")
      ->check(OneOf({"local", "slurm"}))
      ->capture_default_str()
      ->type_name("local|slurm");
  app.add_option("--piece_minutes", cut_.minutes,
                 "Learn each drive in pieces of equal length, of this many minutes at most, which "
                 "are merged; the maps are not those of one piece. 0: in one piece, or in those "
                 "of `cuts` in the manifest")
      ->check(AtLeast(0.0))
      ->type_name("MINUTES");
  app.add_flag("--scene_cuts", cut_.at_scenes,
               "With --piece_minutes: end pieces where the picture cuts to another scene, as far "
               "as that leaves them long; each drive is read for it once");
  app.add_option("--cpus", cpus_, "Processors of each task; 0: what the engine gives")
      ->check(Between(0, 1024))
      ->type_name("NUMBER");
  app.add_option("--task", task_, "Runs one task of the plan, from 0, and nothing else")
      ->check(AtLeast<int64_t>(0))
      ->type_name("K");
  app.add_flag("--plan", plan_, "Print the tasks with their numbers, and run nothing");
  app.add_flag("--status", status_, "Print how far each drive is, and run nothing");
  app.add_option("--sbatch", sbatch_,
                 "Further options of sbatch, separated by spaces: '--partition=long --nice=100'")
      ->type_name("OPTIONS");
  app.add_option("--measured_frames", measured_frames_,
                 "Frames on which --engine=slurm measures what time and memory to ask for")
      ->check(Between<int64_t>(2, 100000))
      ->capture_default_str()
      ->type_name("FRAMES");
  app.add_flag("--dry_run", dry_run_, "With --engine=slurm: measure, write the scripts, no more");
  for (const char* flag :
       {"--scene_cuts", "--cpus", "--sbatch", "--measured_frames", "--dry_run"}) {
    of_plans_.push_back(app.get_option(flag));
  }
}

bool PlanRun::IsAskedFor() const {
  return engine_ != "local" || task_.has_value() || plan_ || status_;
}

absl::Status PlanRun::CheckUnplanned(const std::vector<BatchEntry>& entries) const {
  const bool is_cut =
      std::any_of(entries.begin(), entries.end(), [](const auto& e) { return !e.cuts.empty(); });
  if (cut_.minutes != 0.0 || is_cut) {
    return absl::InvalidArgumentError(
        "pieces of drives (--piece_minutes, cuts) are learnt by --engine=slurm or --task; without "
        "those leave them out");
  }
  if (const std::string flags = GivenFlags(of_plans_); !flags.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("no effect without --engine=slurm, --task, --plan or --status: ", flags,
                     "; leave them out"));
  }
  return absl::OkStatus();
}

absl::StatusOr<ExitCode> PlanRun::Run(const std::string& manifest, std::vector<BatchEntry> entries,
                                      const ResultFlag& result) const {
  if ((engine_ != "local") + (task_.has_value()) + plan_ + status_ > 1) {
    return absl::InvalidArgumentError("--engine, --task, --plan and --status exclude each other");
  }
  if (cut_.at_scenes && cut_.minutes == 0.0) {
    return absl::InvalidArgumentError("--scene_cuts needs --piece_minutes; give both");
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckThen(entries));
  EGOSIEVE_RETURN_IF_ERROR(CutDrives(cut_, entries));
  EGOSIEVE_RETURN_IF_ERROR(CheckCuts(entries));
  const BatchPlan plan(WithAbsolutePaths(std::move(entries)), cpus_);
  if (task_.has_value()) return RunTask(plan);
  if (plan_) return TellPlan(plan, result);
  if (status_) return TellStatus(plan, JobsFolder(manifest), result);
  return SubmitPlan(plan, JobsFolder(manifest), result);
}

absl::StatusOr<ExitCode> PlanRun::RunTask(const BatchPlan& plan) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string program, OwnProgram());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> arguments,
                            plan.ArgumentsOfReadyTask(*task_));
  if (arguments.empty()) return ExitCode::kDone;
  if (!plan.IsNoted(static_cast<size_t>(*task_) / plan.entries().size())) {
    return BecomeProgram(program, arguments);
  }
  std::vector<std::string> words = arguments;
  words.insert(words.begin(), program);
  EGOSIEVE_ASSIGN_OR_RETURN(const int code, RunChild({words, {}, ""}, InterruptionRequested));
  if (code == static_cast<int>(ExitCode::kDone) ||
      code == static_cast<int>(ExitCode::kFramesFailed)) {
    EGOSIEVE_RETURN_IF_ERROR(plan.NoteDone(*task_));
  }
  return static_cast<ExitCode>(code);
}

absl::StatusOr<ExitCode> PlanRun::TellPlan(const BatchPlan& plan, const ResultFlag& result) const {
  std::string text;
  nlohmann::ordered_json tasks = nlohmann::ordered_json::array();
  const int width = static_cast<int>(WidestRun(plan));
  for (size_t stage = 0; stage < plan.stages().size(); ++stage) {
    for (size_t drive = 0; drive < plan.entries().size(); ++drive) {
      const std::vector<std::string> arguments = plan.Arguments(stage, drive);
      if (arguments.empty()) continue;
      const int64_t number = plan.TaskNumber(stage, drive);
      const std::string& out = plan.entries()[drive].out;
      const std::string& name = plan.stages()[stage].name;
      absl::StrAppendFormat(&text, "%6d  %-*s  %s\n", number, width, out, name);
      tasks.push_back({{"task", number}, {"run", out}, {"stage", name}, {"arguments", arguments}});
    }
  }
  result.Tell("batch", {{"tasks", tasks}}, text);
  return ExitCode::kDone;
}

absl::StatusOr<ExitCode> PlanRun::TellStatus(const BatchPlan& plan, const std::string& folder,
                                             const ResultFlag& result) const {
  const int width = static_cast<int>(WidestRun(plan));
  std::string table =
      absl::StrFormat("%-*s  %-11s  %8s  %8s  %17s  %-11s  %s\n", width, "run", "segment", "frames",
                      "failed", "maps", "reconstruct", "report");
  nlohmann::ordered_json drives = nlohmann::ordered_json::array();
  for (const BatchEntry& entry : plan.entries()) {
    for (size_t piece = 1; piece <= entry.cuts.size() + 1; ++piece) {
      const std::string run = PieceFolder(entry, static_cast<int>(piece));
      const DriveProgress progress = ProgressOf(run);
      absl::StrAppend(&table, StatusRow(run, width, progress), "\n");
      drives.push_back({{"run", run},
                        {"segment", progress.state},
                        {"frames", progress.frames},
                        {"frames_failed", progress.frames_failed},
                        {"maps", progress.maps},
                        {"reconstructed", progress.is_reconstructed},
                        {"report", progress.has_report},
                        {"reason", progress.reason}});
    }
  }
  const std::string jobs = SubmittedJobs(folder);
  if (!jobs.empty()) absl::StrAppend(&table, "submitted to Slurm: squeue --jobs=", jobs, "\n");
  result.Tell("batch", {{"drives", drives}, {"jobs", jobs}}, table);
  return ExitCode::kDone;
}

absl::StatusOr<ExitCode> PlanRun::SubmitPlan(const BatchPlan& plan, const std::string& folder,
                                             const ResultFlag& result) const {
  SlurmOptions options;
  EGOSIEVE_ASSIGN_OR_RETURN(options.program, OwnProgram());
  options.folder = folder;
  options.sbatch = absl::StrSplit(sbatch_, ' ', absl::SkipWhitespace());
  options.submit = !dry_run_;
  const std::vector<size_t> drives = plan.UnfinishedDrives();
  if (drives.empty()) {
    result.Tell("batch", {{"arrays", nlohmann::ordered_json::array()}},
                "every drive is done; nothing was submitted\n");
    return ExitCode::kDone;
  }
  if (options.submit) EGOSIEVE_RETURN_IF_ERROR(CheckNothingIsQueued(folder));
  EGOSIEVE_ASSIGN_OR_RETURN(
      const BatchCost cost,
      MeasureCost(options.program, plan, folder + "/measured", measured_frames_));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SlurmArray> arrays,
                            SubmitToSlurm(plan, drives, cost, options));
  std::string text;
  nlohmann::ordered_json told = nlohmann::ordered_json::array();
  for (const SlurmArray& array : arrays) {
    const PlanStage& stage = plan.stages()[array.stage];
    const TaskRequest request = RequestFor(plan, array.stage, cost, options);
    absl::StrAppendFormat(&text, "%-12s  %5d tasks  %5d min  %6d MiB  job %s  %s\n", stage.name,
                          array.tasks, request.minutes, request.memory_mebibytes,
                          array.job.empty() ? "-" : array.job, array.script);
    told.push_back({{"stage", stage.name},
                    {"tasks", array.tasks},
                    {"minutes", request.minutes},
                    {"memory_mebibytes", request.memory_mebibytes},
                    {"job", array.job},
                    {"script", array.script}});
  }
  result.Tell("batch", {{"arrays", told}}, text);
  return ExitCode::kDone;
}

}  // namespace egosieve::tools
