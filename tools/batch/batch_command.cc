// egosieve batch INPUT: many drives.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drives.h"
#include "tools/batch/plan.h"
#include "tools/batch/slurm.h"
#include "tools/cli/checks.h"
#include "tools/cli/child_process.h"
#include "tools/cli/command.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

// Runs the tasks of a batch on this machine, several at the same time, which share the threads; a
// drive goes to its end before the next begins, as far as its tasks leave programs free. Ends early
// if interrupted. A failing task ends its drive and no other. Each task is a line on stderr.
class DrivesRun {
 public:
  // program: egosieve.
  DrivesRun(const BatchPlan& plan, std::string program)
      : plan_(plan), program_(std::move(program)), tasks_(plan.tasks().size(), State::kWaiting) {}

  void Run(int jobs) {
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
  }

 private:
  enum class State { kWaiting, kRunning, kDone, kOver };  // kOver: failed or interrupted

  // Runs the first task that can begin, drive by drive; false if there is none now.
  bool RunNext(std::unique_lock<std::mutex>& lock) {
    for (size_t drive = 0; drive < plan_.drives().size(); ++drive) {
      for (size_t stage = 0; stage < plan_.stages(); ++stage) {
        const size_t task = plan_.Number(stage, drive);
        const std::vector<size_t>& needs = plan_.tasks()[task].needs;
        if (tasks_[task] == State::kWaiting &&
            std::all_of(needs.begin(), needs.end(),
                        [&](size_t needed) { return tasks_[needed] == State::kDone; })) {
          RunTask(task, lock);
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

  void RunTask(size_t task, std::unique_lock<std::mutex>& lock) {
    tasks_[task] = State::kRunning;
    lock.unlock();
    bool has_begun = false;  // a task that is done has no program
    const absl::StatusOr<int> code = plan_.Run(task, program_, /*to_log=*/true, [&] {
      const std::lock_guard<std::mutex> own(mutex_);
      if (!std::exchange(has_begun, true)) Say(task, "");
      return InterruptionRequested();
    });
    lock.lock();
    const bool is_good = code.ok() && TaskRecord{"", *code, 0.0, ""}.is_good();
    tasks_[task] = is_good ? State::kDone : State::kOver;
    if (!code.ok()) {
      Say(task, absl::StrCat(" failed: ", code.status().message()));
    } else if (has_begun || !is_good) {
      Say(task, is_good ? " done" : *code == 130 ? " interrupted" : " failed");
    }
  }

  void Say(size_t task, const std::string& what) const {
    std::cerr << absl::StrFormat("batch: %d of %d, %s: %s%s\n", task % plan_.drives().size() + 1,
                                 plan_.drives().size(), plan_.DriveOf(task).out,
                                 plan_.tasks()[task].stage, what);
  }

  const BatchPlan& plan_;
  const std::string program_;
  std::mutex mutex_;  // of all below
  std::condition_variable ended_;
  std::vector<State> tasks_;  // by number
};

// How far a drive is: from the book and the run folder alone, at any time and on any machine that
// sees them.
struct DriveStatus {
  std::string state = "not started";  // begun, failed, frames failed, done
  int tasks = 0, tasks_done = 0;
  int exit_code = 0;  // of the first task that failed, wholly or in some frames
  int64_t frames = 0, frames_failed = 0;
  double seconds = 0.0;  // of the tasks that were run last
  std::string reason;    // the error's line, if one failed
};

// NotFound if there is no run yet.
absl::Status CountFrames(const std::string& run, DriveStatus& status) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(run));
  EGOSIEVE_RETURN_IF_ERROR(folder.ReadDescription().status());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  status.frames = static_cast<int64_t>(lines.size());
  status.frames_failed = std::count_if(lines.begin(), lines.end(), [](const FrameLine& line) {
    return line.outcome == FrameLine::Outcome::kFailed;
  });
  return absl::OkStatus();
}

// What the table shows of a drive after its state: names of columns, and text.
std::vector<std::pair<const char*, std::string>> Columns(const DriveStatus& drive) {
  return {{"tasks", absl::StrCat(drive.tasks_done, " of ", drive.tasks)},
          {"code", absl::StrCat(drive.exit_code)},
          {"frames", absl::StrCat(drive.frames)},
          {"failed", absl::StrCat(drive.frames_failed)},
          {"time", DescribeDuration(drive.seconds)}};
}

DriveStatus StatusOf(const BatchPlan& plan, size_t drive) {
  DriveStatus status;
  const absl::Status run = CountFrames(plan.drives()[drive].out, status);
  if (!absl::IsNotFound(run)) status.state = run.ok() ? "begun" : "failed";
  if (status.state == "failed") status.reason = std::string(run.message());
  for (size_t task = drive; task < plan.tasks().size(); task += plan.drives().size()) {
    if (plan.tasks()[task].arguments.empty()) continue;
    const std::optional<TaskRecord> record = plan.Record(task);
    const bool is_done = plan.IsDone(task);
    ++status.tasks;
    status.tasks_done += is_done;
    if (!record) continue;
    status.seconds += record->seconds;
    if (status.exit_code == 0 && record->exit_code != 0) {
      status.exit_code = record->exit_code;
      const std::string& name = plan.tasks()[task].stage;
      status.reason = name == "segment" ? record->reason : absl::StrCat(name, ": ", record->reason);
    }
    if (!record->is_good() && !is_done) status.state = "failed";
  }
  if (status.tasks_done == status.tasks) {
    status.state = status.exit_code != 0 || status.frames_failed > 0 ? "frames failed" : "done";
  }
  return status;
}

std::vector<DriveStatus> StatusOfAll(const BatchPlan& plan) {
  std::vector<DriveStatus> drives;
  for (size_t i = 0; i < plan.drives().size(); ++i) drives.push_back(StatusOf(plan, i));
  return drives;
}

void TellStatus(const BatchPlan& plan, const std::vector<DriveStatus>& drives,
                const ResultFlag& result) {
  int width = 3;
  for (const BatchDrive& entry : plan.drives()) {
    width = std::max(width, static_cast<int>(entry.out.size()));
  }
  std::string table = absl::StrFormat("%-*s  %13s", width, "run", "state");
  for (const auto& [name, text] : Columns({})) absl::StrAppendFormat(&table, "  %13s", name);
  nlohmann::ordered_json told = nlohmann::ordered_json::array();
  for (size_t i = 0; i < drives.size(); ++i) {
    const DriveStatus& drive = drives[i];
    absl::StrAppendFormat(&table, "\n%-*s  %13s", width, plan.drives()[i].out, drive.state);
    for (const auto& [name, text] : Columns(drive)) absl::StrAppendFormat(&table, "  %13s", text);
    absl::StrAppend(&table, drive.reason.empty() ? "" : "  ", drive.reason);
    told.push_back({{"run", plan.drives()[i].out},
                    {"state", drive.state},
                    {"tasks", drive.tasks},
                    {"tasks_done", drive.tasks_done},
                    {"exit_code", drive.exit_code},
                    {"frames", drive.frames},
                    {"frames_failed", drive.frames_failed},
                    {"seconds", drive.seconds},
                    {"reason", drive.reason}});
  }
  result.Tell("batch", {{"drives", told}}, table + "\n");
}

using Json = nlohmann::ordered_json;

class BatchCommand : public Command {
 public:
  std::string name() const override { return "batch"; }
  std::string summary() const override {
    return "Segments many drives and runs further commands on them, here or as numbered tasks on "
           "many machines; does what is missing, ends with a table.";
  }
  std::string example() const override {
    return "egosieve batch videos --out=out --jobs=2 --then=refine,masks,render,report\n"
           "egosieve batch 'videos/*.mp4' --out=out --segment_flags='--profile=fast --stride=3'\n"
           "egosieve batch drives.toml --engine=slurm --sbatch=--cpus-per-task=4\n"
           "egosieve batch drives.toml --status\n"
           "  # [defaults] with out = \"out\", then = [\"refine\", \"masks\"] and segment's "
           "flags,\n"
           "  # [defaults.masks] with those of masks; then a table per drive, [a] with path = "
           "\"a.mp4\"";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", inputs_,
                   "A folder or a glob of drives (videos, and folders of pictures or videos), or "
                   "a manifest, in TOML; or the plan that --plan has written")
        ->required()
        ->default_str("")
        ->type_name("")
        ->configurable(false);
    app.add_option("-o,--out", given_.out,
                   "The folder for the run folders, which go by the drives' names; of a manifest "
                   "for drives that name none")
        ->type_name("DIR");
    app.add_option("-j,--jobs", jobs_, "Tasks at the same time, which share the threads")
        ->check(Between(1, 256))
        ->type_name("NUMBER");
    app.add_option("--then", given_.then,
                   absl::StrCat(
                       "What follows segment, by commas: ", absl::StrJoin(kFollowingCommands, ", "),
                       "; default: refine,report; none: nothing. Masks go to "
                       "OUT/NAME.masks. What has been done on the same run with the same "
                       "flags is left"))
        ->type_name("COMMANDS");
    app.add_option("--segment_flags", given_.segment_flags,
                   "Flags of segment for all drives, in quotes")
        ->type_name("FLAGS");
    app.add_option("--masks_flags", given_.masks_flags,
                   "Flags of masks for all drives, in quotes: '--for=colmap --dilate=10'; those "
                   "of other commands go into a manifest")
        ->type_name("FLAGS");
    app.add_option("--engine", engine_,
                   "local: runs the tasks here; slurm: submits what is not done as job arrays")
        ->check(OneOf({"local", "slurm"}))
        ->capture_default_str()
        ->type_name("local|slurm");
    app.add_option("--piece_minutes", piece_minutes_,
                   "Learn each drive in pieces of equal length, of this many minutes at most, "
                   "which are merged; the maps are not those of one piece. 0: in one piece, or in "
                   "those of `cuts` in the manifest")
        ->check(AtLeast(0.0))
        ->type_name("MINUTES");
    app.add_option("--task", task_, "Runs one task of the plan, from 0, and nothing else")
        ->check(AtLeast<int64_t>(0))
        ->type_name("K");
    app.add_flag("--plan", plan_,
                 "Print the tasks with their numbers, write them to egosieve_jobs/, run nothing");
    app.add_flag("--status", status_, "Print how far each drive is, run nothing");
    app.add_option("--sbatch", sbatch_,
                   "Further options of sbatch, separated by spaces: '--time=300 --mem=4G'; a task "
                   "that reaches its time limit goes on from there")
        ->type_name("OPTIONS");
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(CheckFlags());
    EGOSIEVE_ASSIGN_OR_RETURN(const BatchPlan plan, MakePlan());
    if (task_.has_value()) return RunTask(plan);
    if (plan_) return TellPlan(plan);
    if (engine_ == "slurm") return SubmitPlan(plan);
    if (!status_) return RunHere(plan);
    TellStatus(plan, StatusOfAll(plan), result_);
    return ExitCode::kDone;
  }

 private:
  absl::Status CheckFlags() const {
    if ((engine_ != "local") + (task_.has_value()) + plan_ + status_ > 1) {
      return absl::InvalidArgumentError("--engine, --task, --plan and --status exclude each other");
    }
    if (engine_ == "local" && !sbatch_.empty()) {
      return absl::InvalidArgumentError("no effect without --engine=slurm: --sbatch; leave it out");
    }
    return absl::OkStatus();
  }

  static bool IsPlan(const std::string& input) {
    return std::filesystem::path(input).extension() == ".json";
  }

  absl::StatusOr<BatchPlan> MakePlan() const {
    const std::string& input = inputs_.front();
    if (!IsPlan(input)) {
      EGOSIEVE_ASSIGN_OR_RETURN(std::vector<BatchDrive> drives, ReadDrives(inputs_, given_));
      if (piece_minutes_ > 0.0) CutDrives(piece_minutes_, drives);
      return BatchPlan::Create(std::move(drives));
    }
    if (inputs_.size() > 1 || piece_minutes_ > 0.0 || given_.then || !given_.out.empty() ||
        !given_.segment_flags.empty() || !given_.masks_flags.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat(input, " is a plan, with drives and flags of its own; leave others out"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(input));
    const absl::StatusOr<BatchPlan> plan = BatchPlan::FromText(text);
    if (plan.ok()) return plan;
    return absl::InvalidArgumentError(absl::StrCat(
        input,
        " is no plan that --plan has written (manifests are TOML): ", plan.status().message()));
  }

  absl::StatusOr<ExitCode> RunHere(const BatchPlan& plan) const {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string program, OwnProgram());
    DrivesRun(plan, program).Run(jobs_);
    const std::vector<DriveStatus> drives = StatusOfAll(plan);
    TellStatus(plan, drives, result_);
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; the same command goes on");
    }
    const bool is_done = std::all_of(drives.begin(), drives.end(),
                                     [](const DriveStatus& d) { return d.state == "done"; });
    return is_done ? ExitCode::kDone : ExitCode::kFramesFailed;
  }

  absl::StatusOr<ExitCode> RunTask(const BatchPlan& plan) const {
    const size_t task = *task_;
    if (task >= plan.tasks().size()) {
      return absl::OutOfRangeError(
          absl::StrCat("--task=", task, ": the plan has tasks 0 to ", plan.tasks().size() - 1));
    }
    for (const size_t needed : plan.tasks()[task].needs) {
      if (plan.IsDone(needed)) continue;
      return absl::FailedPreconditionError(
          absl::StrCat("the task '", plan.tasks()[needed].stage, "' of ", plan.DriveOf(task).out,
                       " is not done; run it first: --task=", needed));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string program, OwnProgram());
    EGOSIEVE_ASSIGN_OR_RETURN(const int code,
                              plan.Run(task, program, /*to_log=*/false, InterruptionRequested));
    return static_cast<ExitCode>(code);
  }

  // The folder for files of engines: egosieve_jobs/NAME beside the file or the run folders.
  std::string JobsFolder() const {
    const std::string& input = inputs_.front();
    const std::filesystem::path path =
        AbsolutePath(IsPlan(input) || IsManifest(input) ? input : given_.out);
    return (path.parent_path() / "egosieve_jobs" / path.stem()).string();
  }

  absl::StatusOr<ExitCode> TellPlan(const BatchPlan& plan) const {
    const std::string path = JobsFolder() + "/plan.json";
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(JobsFolder()));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(path, plan.ToText()));
    std::string text;
    size_t width = 3;
    for (const BatchDrive& drive : plan.drives()) width = std::max(width, drive.out.size());
    for (size_t task = 0; task < plan.tasks().size(); ++task) {
      if (plan.tasks()[task].arguments.empty()) continue;
      absl::StrAppendFormat(&text, "%6d  %-*s  %s\n", task, static_cast<int>(width),
                            plan.DriveOf(task).out, plan.tasks()[task].stage);
    }
    absl::StrAppend(&text, "a task of it: egosieve batch ", path, " --task=K\n");
    result_.Tell("batch", {{"tasks", plan.ToJson()["tasks"]}, {"plan", path}}, text);
    return ExitCode::kDone;
  }

  absl::StatusOr<ExitCode> SubmitPlan(const BatchPlan& plan) const {
    SlurmOptions options;
    EGOSIEVE_ASSIGN_OR_RETURN(options.program, OwnProgram());
    options.folder = JobsFolder();
    options.sbatch = absl::StrSplit(sbatch_, ' ', absl::SkipWhitespace());
    std::vector<size_t> drives;
    const std::vector<DriveStatus> all = StatusOfAll(plan);
    for (size_t i = 0; i < all.size(); ++i) {
      if (all[i].tasks_done < all[i].tasks) drives.push_back(i);
    }
    std::string text = drives.empty() ? "every drive is done; nothing was submitted\n" : "";
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SlurmArray> arrays,
                              SubmitToSlurm(plan, drives, options));
    Json told = Json::array();
    for (const SlurmArray& array : arrays) {
      const std::string& stage = plan.tasks()[plan.Number(array.stage, 0)].stage;
      absl::StrAppendFormat(&text, "%-12s  %5d tasks  job %s\n", stage, array.tasks, array.job);
      told.push_back({{"stage", stage}, {"tasks", array.tasks}, {"job", array.job}});
    }
    result_.Tell("batch", {{"arrays", told}}, text);
    return ExitCode::kDone;
  }

  std::vector<std::string> inputs_;
  BatchSettings given_;
  int jobs_ = 1;
  std::string engine_ = "local", sbatch_;
  double piece_minutes_ = 0.0;
  bool plan_ = false, status_ = false;
  std::optional<size_t> task_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeBatchCommand() { return std::make_unique<BatchCommand>(); }

}  // namespace egosieve::tools
