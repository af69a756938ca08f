#include "tools/batch/slurm.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/status.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_input.h"
#include "tools/suite/child_process.h"

namespace egosieve::tools {
namespace {

constexpr double kTimeShare = 2.0, kMemoryShare = 1.5;
constexpr int64_t kMebibyte = 1 << 20, kMemoryStep = 128;

// Quotes text for a shell.
std::string Quoted(const std::string& text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"'", "'\\''"}}), "'");
}

// The end of the names of a folder's jobs, by which they are found again: a hash (FNV-1a).
std::string JobSuffix(const std::string& folder) {
  uint64_t hash = 14695981039346656037u;
  for (const char letter : AbsolutePath(folder)) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211u;
  }
  return absl::StrFormat("-%016x", hash);
}

bool HasControlCharacter(const std::string& text) {
  return std::any_of(text.begin(), text.end(),
                     [](char letter) { return absl::ascii_iscntrl(letter); });
}

// A line of sbatch's options: it reads words as a shell does, within double quotes.
std::string SbatchLine(const std::string& word) {
  return absl::StrCat("#SBATCH \"", absl::StrReplaceAll(word, {{"\\", "\\\\"}, {"\"", "\\\""}}),
                      "\"\n");
}

// "0-3,7"
std::string Ranges(const std::vector<size_t>& numbers) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    ranges.push_back(end - i == 1 ? absl::StrCat(numbers[i])
                                  : absl::StrCat(numbers[i], "-", numbers[end - 1]));
    i = end;
  }
  return absl::StrJoin(ranges, ",");
}

// The output of a Slurm program; Unavailable, with its message, if it failed.
absl::StatusOr<std::string> Call(std::vector<std::string> words, const std::string& folder) {
  const std::string log_path = folder + "/slurm.log", name = words.front();
  words.insert(words.begin(), "/usr/bin/env");
  EGOSIEVE_ASSIGN_OR_RETURN(const int code, RunChild({words, {}, log_path}, [] { return false; }));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string said, ReadFile(log_path));
  const std::string text = std::string(absl::StripAsciiWhitespace(said));
  if (code == 0) return text;
  return absl::UnavailableError(
      absl::StrCat(name, " ended with exit code ", code, ": ", text,
                   "; --engine=slurm needs Slurm's programs and a cluster that answers"));
}

// The numbers of this folder's jobs that are queued or running, whoever has noted them.
absl::StatusOr<std::vector<std::string>> QueuedJobs(const std::string& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string queue,
                            Call({"squeue", "--noheader", "--format=%A %j"}, folder));
  std::vector<std::string> jobs;
  for (const absl::string_view line : absl::StrSplit(queue, '\n')) {
    if (!absl::EndsWith(absl::StripAsciiWhitespace(line), JobSuffix(folder))) continue;
    std::string job(line.substr(0, line.find(' ')));
    if (jobs.empty() || jobs.back() != job) jobs.push_back(std::move(job));
  }
  return jobs;
}

// Cancels the folder's jobs after `cause`, which is returned with what could not be cancelled.
absl::Status CancelJobs(const std::string& folder, const absl::Status& cause) {
  const absl::StatusOr<std::vector<std::string>> jobs = QueuedJobs(folder);
  absl::Status cancelled = jobs.status();
  if (jobs.ok() && !jobs->empty()) {
    std::vector<std::string> words = {"scancel"};
    words.insert(words.end(), jobs->begin(), jobs->end());
    cancelled = Call(std::move(words), folder).status();
  }
  if (cancelled.ok()) return cause;
  return absl::Status(cause.code(),
                      absl::StrCat(cause.message(), "; jobs whose names end in ", JobSuffix(folder),
                                   " may be left, cancel them: ", cancelled.message()));
}

// The job's number, on the last line: warnings may precede it.
absl::StatusOr<std::string> Submit(const std::string& script, const std::string& dependency,
                                   const std::string& folder) {
  std::vector<std::string> words = {"sbatch", "--parsable"};
  if (!dependency.empty()) {
    words.insert(words.end(), {"--dependency=" + dependency, "--kill-on-invalid-dep=yes"});
  }
  words.push_back(script);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string said, Call(std::move(words), folder));
  const std::vector<std::string> lines = absl::StrSplit(said, '\n');
  const std::string job = lines.back().substr(0, lines.back().find(';'));
  int64_t number = 0;
  if (!absl::SimpleAtoi(job, &number)) {
    return absl::UnavailableError(absl::StrCat("sbatch printed no job number but: ", said));
  }
  return job;
}

// Submits the array's script.
absl::Status SubmitArray(const BatchPlan& plan, const std::vector<std::string>& job_of_stage,
                         const std::string& folder, SlurmArray& array) {
  if (InterruptionRequested()) {
    return absl::CancelledError("interrupted; the jobs submitted before are cancelled");
  }
  std::string dependency;
  for (const size_t needed : plan.stages()[array.stage].needs) {
    absl::StrAppend(&dependency, dependency.empty() ? "aftercorr" : "", ":", job_of_stage[needed]);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(array.job, Submit(array.script, dependency, folder));
  return absl::OkStatus();
}

// The number of the drive with the largest pictures; sets the longest drive's frames. A drive that
// cannot be read counts nothing: its task reports the error.
absl::StatusOr<size_t> LargestDrive(const BatchPlan& plan, int64_t& longest_frames) {
  absl::Status failure;
  int64_t most_pixels = 0;
  size_t largest = 0;
  for (size_t i = 0; i < plan.entries().size(); ++i) {
    const absl::StatusOr<DriveInput> input = OpenDriveInput(plan.entries()[i].path, 0);
    failure.Update(input.status());
    if (!input.ok()) continue;
    const int64_t pixels = static_cast<int64_t>(input->width_pixels) * input->height_pixels;
    if (pixels > most_pixels) largest = i;
    most_pixels = std::max(most_pixels, pixels);
    longest_frames = std::max(longest_frames, input->frames->expected_frame_count());
  }
  if (most_pixels == 0) return failure;
  return largest;
}

absl::Status MeasureStages(const BatchPlan& piece, const std::string& program, BatchCost& cost) {
  for (size_t stage = 0; stage < piece.stages().size(); ++stage) {
    const std::string& command = piece.stages()[stage].command;
    EGOSIEVE_ASSIGN_OR_RETURN(
        const int code, piece.Run(stage, 0, program, /*to_log=*/true, InterruptionRequested));
    const std::optional<TaskRecord> record = piece.Record(stage, 0);
    if (InterruptionRequested() || !record) {
      return absl::CancelledError("interrupted while measuring; nothing was submitted");
    }
    if (!record->is_good()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "measuring: 'egosieve ", command, "' ended with exit code ", code, ": ", record->reason));
    }
    if (stage == 0) cost.measured_frames = std::max<int64_t>(1, StatusOf(piece, 0).frames);
    cost.seconds_per_frame[command] = record->seconds / static_cast<double>(cost.measured_frames);
  }
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  cost.peak_memory_bytes = int64_t{1024} * usage.ru_maxrss;
  return absl::OkStatus();
}

}  // namespace

absl::Status SlurmOptions::Validate() const {
  if (program.empty() || folder.empty()) {
    return absl::InvalidArgumentError("program and folder must not be empty");
  }
  if (HasControlCharacter(folder) || absl::StrContains(folder, '\\')) {
    return absl::InvalidArgumentError(
        absl::StrCat("Slurm cannot write logs into ", folder,
                     ": no backslash or line break may be in its path; name another folder"));
  }
  for (const std::string& option : sbatch) {
    if (!absl::StartsWith(option, "-") || HasControlCharacter(option)) {
      return absl::InvalidArgumentError(
          absl::StrCat("--sbatch: '", option, "' is no option; give, say, --partition=long"));
    }
    for (const char* own : {"--job-name", "-J", "--array", "-a", "--output", "-o"}) {
      if (absl::StartsWith(option, own) &&
          (own[1] != '-' || option == own || absl::StartsWith(option, absl::StrCat(own, "=")))) {
        return absl::InvalidArgumentError(
            absl::StrCat("--sbatch: ", own, " is the batch's own; leave it out"));
      }
    }
  }
  if (largest_array < 1) return absl::InvalidArgumentError("largest_array must be at least 1");
  return absl::OkStatus();
}

absl::StatusOr<BatchCost> MeasureCost(const BatchPlan& plan, const std::string& program,
                                      const std::string& scratch, int64_t frames) {
  BatchCost cost;
  EGOSIEVE_ASSIGN_OR_RETURN(const size_t largest, LargestDrive(plan, cost.longest_drive_frames));
  BatchEntry entry = plan.entries()[largest];
  entry.out = scratch + "/run";
  entry.cuts.clear();
  std::erase_if(entry.flags,
                [](const std::string& flag) { return absl::StartsWith(flag, "--max_frames="); });
  entry.flags.push_back(absl::StrCat("--max_frames=", frames));
  EGOSIEVE_ASSIGN_OR_RETURN(const BatchPlan piece, BatchPlan::Create({entry}, plan.threads()));
  std::error_code error;
  std::filesystem::remove_all(scratch, error);
  const absl::Status status = MeasureStages(piece, program, cost);
  std::filesystem::remove_all(scratch, error);
  EGOSIEVE_RETURN_IF_ERROR(status);
  return cost;
}

TaskRequest RequestFor(const BatchPlan& plan, size_t stage, const BatchCost& cost,
                       const SlurmOptions& options) {
  const PlanStage& asked = plan.stages()[stage];
  const auto seconds_of = [&](const std::string& command) {
    const auto measured = cost.seconds_per_frame.find(command);
    return measured == cost.seconds_per_frame.end() ? 0.0 : measured->second;
  };
  const int64_t frames =
      asked.piece > 0 ? plan.LongestPiece(cost.longest_drive_frames) : cost.longest_drive_frames;
  const double seconds =
      seconds_of(asked.command) * static_cast<double>(std::max(frames, cost.measured_frames));
  const double steps = kMemoryShare * static_cast<double>(cost.peak_memory_bytes) /
                       static_cast<double>(kMemoryStep * kMebibyte);
  return {options.longest_wait_minutes + static_cast<int64_t>(std::ceil(kTimeShare * seconds / 60)),
          kMemoryStep * static_cast<int64_t>(std::ceil(steps))};
}

std::string SlurmScript(const BatchPlan& plan, size_t stage, const std::vector<size_t>& drives,
                        const TaskRequest& request, const SlurmOptions& options) {
  const size_t first = drives.front() - drives.front() % options.largest_array;
  std::vector<size_t> elements;
  for (const size_t drive : drives) elements.push_back(drive - first);
  const std::string name = plan.stages()[stage].file_name();
  std::string script =
      absl::StrCat("#!/bin/bash\n#SBATCH --job-name=egosieve-", name, JobSuffix(options.folder),
                   "\n#SBATCH --array=", Ranges(elements), "\n#SBATCH --time=", request.minutes,
                   "\n#SBATCH --mem=", request.memory_mebibytes, "M");
  if (plan.threads() > 0) absl::StrAppend(&script, "\n#SBATCH --cpus-per-task=", plan.threads());
  absl::StrAppend(
      &script, "\n#SBATCH --requeue --open-mode=append --signal=B:USR1@60\n",
      SbatchLine(absl::StrCat("--output=", absl::StrReplaceAll(options.folder, {{"%", "%%"}}), "/",
                              name, first > 0 ? absl::StrCat("_", first) : "", ".%a.log")));
  for (const std::string& option : options.sbatch) absl::StrAppend(&script, SbatchLine(option));
  absl::StrAppend(&script, R"sh(
# USR1: the time limit is near; the task ends with what it wrote whole, and is queued again.
task= asked= again=
end() { asked=yes; [ -z "$task" ] || kill -TERM $task; }
trap 'again=yes; end' USR1
trap end TERM
)sh",
                  Quoted(options.program), " batch ", Quoted(options.folder + "/drives.json"));
  if (plan.threads() > 0) absl::StrAppend(&script, " --cpus=", plan.threads());
  absl::StrAppend(&script, " --task=$((", plan.TaskNumber(stage, first),
                  R"sh( + SLURM_ARRAY_TASK_ID)) &
task=$!
[ -z "$asked" ] || end # a signal that came before its number was known
while kill -0 $task 2>/dev/null; do wait $task; done
wait $task
code=$?
# 143: the signal came before the program could catch it.
if [ -n "$again" ] && { [ "$code" -eq 130 ] || [ "$code" -eq 143 ]; }; then
  exec scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
[ "$code" -ne 4 ] || code=0 # finished, some frames failed: the table names them
exit "$code"
)sh");
  return script;
}

absl::Status CheckNothingIsQueued(const std::string& folder) {
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> jobs, QueuedJobs(folder));
  if (jobs.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("jobs of an earlier submission are queued or running; wait for them, or end "
                   "them: scancel ",
                   absl::StrJoin(jobs, " ")));
}

absl::StatusOr<std::vector<SlurmArray>> SubmitToSlurm(const BatchPlan& plan,
                                                      const std::vector<size_t>& drives,
                                                      const BatchCost& cost,
                                                      const SlurmOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(options.folder));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(options.folder + "/drives.json", ToManifest(plan.entries())));
  std::map<size_t, std::vector<size_t>> blocks;  // of drives that share arrays, by number
  for (const size_t drive : drives) {
    blocks[drive / options.largest_array].push_back(drive);
  }
  std::vector<SlurmArray> arrays;
  bool has_submitted = false;
  for (const auto& [block, members] : blocks) {
    std::vector<std::string> job_of_stage;
    for (size_t stage = 0; stage < plan.stages().size(); ++stage) {
      SlurmArray array = {stage, static_cast<int64_t>(members.size()),
                          absl::StrCat(options.folder, "/", plan.stages()[stage].file_name(),
                                       block > 0 ? absl::StrCat("_", block) : "", ".sh"),
                          ""};
      const std::string script =
          SlurmScript(plan, stage, members, RequestFor(plan, stage, cost, options), options);
      absl::Status status = WriteFileAtomically(array.script, script);
      if (status.ok() && options.submit) {
        has_submitted = true;  // sbatch may fail after it has submitted
        status = SubmitArray(plan, job_of_stage, options.folder, array);
      }
      if (!status.ok()) return has_submitted ? CancelJobs(options.folder, status) : status;
      job_of_stage.push_back(array.job);
      arrays.push_back(std::move(array));
    }
  }
  return arrays;
}

}  // namespace egosieve::tools
