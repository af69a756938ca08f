#include "tools/batch/slurm.h"

#include <algorithm>
#include <map>
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
#include "kernels/runtime/tuning.h"
#include "tools/cli/child_process.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

// What a job runs: task.sh PROGRAM PLAN FIRST, where FIRST is the task of the array's element 0.
constexpr char kTaskScript[] = R"sh(#!/bin/bash
# USR1: the time limit is near; the task ends with what it wrote whole, and is queued again.
task= asked= again=
end() { asked=yes; [ -z "$task" ] || kill -TERM $task; }
trap 'again=yes; end' USR1
trap end TERM
[ -z "$SLURM_CPUS_PER_TASK" ] || export EGOSIEVE_THREADS=$SLURM_CPUS_PER_TASK
"$1" batch "$2" --task=$(($3 + SLURM_ARRAY_TASK_ID)) &
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
)sh";

// The end of the names of a folder's jobs, by which they are found again.
std::string JobSuffix(const std::string& folder) {
  return absl::StrFormat("-%016x", kernels::HashBytes(AbsolutePath(folder)));
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
  EGOSIEVE_ASSIGN_OR_RETURN(const int code, RunChild(words, log_path, [] { return false; }));
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

// Submits the array of a stage for these drives, which share one array.
absl::StatusOr<std::string> Submit(const BatchPlan& plan, size_t stage,
                                   const std::vector<size_t>& drives,
                                   const std::vector<std::string>& job_of_stage,
                                   const SlurmOptions& options) {
  if (InterruptionRequested()) return absl::CancelledError("interrupted");
  const size_t first = drives.front() - drives.front() % options.largest_array;
  std::vector<size_t> elements;
  for (const size_t drive : drives) elements.push_back(drive - first);
  const std::string& name = plan.tasks()[plan.Number(stage, 0)].stage;
  // Of an option that is given twice sbatch takes the last: what the batch rests on goes last.
  std::vector<std::string> words = {"sbatch", "--parsable", "--requeue", "--open-mode=append",
                                    "--signal=B:USR1@60"};
  words.insert(words.end(), options.sbatch.begin(), options.sbatch.end());
  words.insert(words.end(),
               {absl::StrCat("--job-name=egosieve-", name, JobSuffix(options.folder)),
                "--array=" + Ranges(elements),
                absl::StrCat("--output=", absl::StrReplaceAll(options.folder, {{"%", "%%"}}), "/",
                             name, first > 0 ? absl::StrCat("_from_", first) : "", ".%a.log")});
  std::vector<std::string> needs;
  for (const size_t needed : plan.tasks()[plan.Number(stage, 0)].needs) {
    needs.push_back(job_of_stage[needed / plan.drives().size()]);
  }
  if (!needs.empty()) {
    words.insert(words.end(), {"--dependency=aftercorr:" + absl::StrJoin(needs, ":"),
                               "--kill-on-invalid-dep=yes"});
  }
  words.insert(words.end(),
               {options.folder + "/task.sh", options.program, options.folder + "/submitted.json",
                absl::StrCat(plan.Number(stage, first))});
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string said, Call(std::move(words), options.folder));
  // The job's number is on the last line: warnings may precede it.
  const std::vector<std::string> lines = absl::StrSplit(said, '\n');
  const std::string job = lines.back().substr(0, lines.back().find(';'));
  int64_t number = 0;
  if (absl::SimpleAtoi(job, &number)) return job;
  return absl::UnavailableError(absl::StrCat("sbatch printed no job number but: ", said));
}

}  // namespace

absl::StatusOr<std::vector<SlurmArray>> SubmitToSlurm(const BatchPlan& plan,
                                                      const std::vector<size_t>& drives,
                                                      const SlurmOptions& options) {
  if (drives.empty()) return std::vector<SlurmArray>();
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(options.folder));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> queued, QueuedJobs(options.folder));
  if (!queued.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("jobs of an earlier submission are queued or running; wait for them, or end "
                     "them: scancel ",
                     absl::StrJoin(queued, " ")));
  }
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(options.folder + "/task.sh", kTaskScript));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(options.folder + "/submitted.json", plan.ToText()));
  std::map<size_t, std::vector<size_t>> blocks;  // of drives that share arrays, by number
  for (const size_t drive : drives) blocks[drive / options.largest_array].push_back(drive);
  std::vector<SlurmArray> arrays;
  for (const auto& [block, members] : blocks) {
    std::vector<std::string> job_of_stage;
    for (size_t stage = 0; stage < plan.stages(); ++stage) {
      const absl::StatusOr<std::string> job = Submit(plan, stage, members, job_of_stage, options);
      if (!job.ok()) {
        return absl::Status(job.status().code(),
                            absl::StrCat(job.status().message(),
                                         "; jobs that were submitted before go on, and the same "
                                         "command submits the rest once they are over"));
      }
      job_of_stage.push_back(*job);
      arrays.push_back({stage, static_cast<int64_t>(members.size()), *job});
    }
  }
  return arrays;
}

}  // namespace egosieve::tools
