// Runs a batch's plan by Slurm: one job array per stage, in which drive d is element d.
//
// Each array depends, element by element (aftercorr), on the arrays of the stages that it needs: a
// drive continues as soon as its own tasks are done, and a failing drive stops no other. If a node
// fails or a time limit is reached, the task is queued again (--requeue, --signal). A task gets
// SIGTERM a minute before its limit and ends with complete files; its next start continues from
// there.
//
// Files in the jobs' folder: drives.json, the batch as submitted; a script and logs for each array;
// jobs.json, the numbers of the jobs. The jobs' names end in a text of the folder, by which Slurm
// itself tells which of them are queued, also those of a submission that was killed.
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
  std::string folder;               // for scripts and logs, visible on every node
  std::vector<std::string> sbatch;  // further options of sbatch
  bool submit = true;               // false: only write the scripts
  size_t largest_array = 1000;      // elements; Slurm's default allows 1001
  int longest_wait_minutes = 5;     // added to a task's own time in its time limit

  absl::Status Validate() const;
};

// Resources for each task: twice the time of the longest drive by (TC1), and one and a half times
// the measured memory.
struct TaskRequest {
  int64_t minutes = 0;
  int64_t memory_mebibytes = 0;
};
TaskRequest RequestFor(const BatchPlan& plan, size_t stage, const BatchCost& cost,
                       const SlurmOptions& options);

// One array: a stage of some drives; `drives` is increasing.
std::string SlurmScript(const BatchPlan& plan, size_t stage, const std::vector<size_t>& drives,
                        const TaskRequest& request, const SlurmOptions& options);

struct SlurmArray {
  size_t stage = 0;
  int64_t tasks = 0;
  std::string script;
  std::string job;  // Slurm's number; empty if not submitted
};

// FailedPrecondition if an earlier submission of the same folder is still queued or running;
// Unavailable if Slurm does not tell.
absl::Status CheckNothingIsQueued(const std::string& folder);

// Writes the scripts of these drives' tasks and submits them. If Slurm refuses a job: Unavailable
// with the message of sbatch; if interrupted: Cancelled. The jobs accepted before are cancelled
// then.
absl::StatusOr<std::vector<SlurmArray>> SubmitToSlurm(const BatchPlan& plan,
                                                      const std::vector<size_t>& drives,
                                                      const BatchCost& cost,
                                                      const SlurmOptions& options);

// The jobs of the last submission, "12,13,14"; empty without one.
std::string SubmittedJobs(const std::string& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_SLURM_H_
