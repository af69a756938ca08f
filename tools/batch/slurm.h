// A batch's plan as jobs of Slurm: a job array for each stage, in which drive d is element d.
//
// Each array depends on the arrays of the stages that it needs, element by element (aftercorr): a
// drive goes on as soon as its own tasks are done, and one that fails stops no other. Nodes that
// fail and time limits requeue a task (--requeue, --signal): a minute before its limit it gets
// SIGTERM, ends with what it wrote whole, and its next start continues from there.
//
// In the jobs' folder: drives.json, the batch as it was submitted; a script and logs for each
// array; jobs.json, Slurm's numbers.
#ifndef EGOSIEVE_TOOLS_BATCH_SLURM_H_
#define EGOSIEVE_TOOLS_BATCH_SLURM_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/plan.h"
#include "tools/batch/task_cost.h"

namespace egosieve::tools {

struct SlurmOptions {
  std::string program;              // egosieve, at the same path on every node
  std::string folder;               // of scripts and logs, seen by every node
  std::vector<std::string> sbatch;  // further options of sbatch
  bool submit = true;               // false: the scripts alone
  size_t largest_array = 1000;      // elements; Slurm's default allows 1001
  int longest_wait_minutes = 5;     // what a time limit has beside the task's own time

  absl::Status Validate() const;
};

// What each task asks for: twice the time of the longest drive by (T1), one and a half times the
// measured memory.
struct TaskRequest {
  int64_t minutes = 0;
  int64_t memory_mebibytes = 0;
};
TaskRequest RequestFor(const BatchPlan& plan, size_t stage, const BatchCost& cost,
                       const SlurmOptions& options);

// One array: a stage of some of the drives, `drives` increasing.
std::string SlurmScript(const BatchPlan& plan, size_t stage, const std::vector<size_t>& drives,
                        const TaskRequest& request, const SlurmOptions& options);

struct SlurmArray {
  size_t stage = 0;
  int64_t tasks = 0;
  std::string script;
  std::string job;  // Slurm's number; empty where nothing was submitted
};

// FailedPrecondition where an earlier submission of the same folder is still queued or running.
absl::Status CheckNothingIsQueued(const std::string& folder);

// Writes the scripts of these drives' tasks and submits them. Unavailable, with what sbatch said,
// where Slurm takes no job; what it took before is cancelled.
absl::StatusOr<std::vector<SlurmArray>> SubmitToSlurm(const BatchPlan& plan,
                                                      const std::vector<size_t>& drives,
                                                      const BatchCost& cost,
                                                      const SlurmOptions& options);

// The jobs of the last submission, "12,13,14"; empty where there was none.
std::string SubmittedJobs(const std::string& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_SLURM_H_
