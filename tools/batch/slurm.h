// Runs a batch's plan by Slurm: one job array per stage, in which drive d is element d.
//
// Each array depends, element by element (aftercorr), on the arrays of the stages that it needs: a
// drive continues as soon as its own tasks are done, and a failing drive stops no other. If a node
// fails or a time limit is reached, the task is queued again (--requeue, --signal). A task gets
// SIGTERM a minute before its limit and ends with complete files; its next start continues from
// there. So a time limit that is too short costs little.
//
// Files in the jobs' folder: submitted.json, the batch as submitted, task.sh, which every job runs,
// and the logs. The jobs' names end in a text of the folder, by which Slurm itself tells which of
// them are queued, also those of a submission that was killed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/batch/plan.h"

namespace egosieve::tools {

struct SlurmOptions {
  std::string program;              // egosieve, at the same path on every node
  std::string folder;               // for scripts and logs, visible on every node
  std::vector<std::string> sbatch;  // further options of sbatch
  size_t largest_array = 1000;      // elements; Slurm's default allows 1001
};

struct SlurmArray {
  size_t stage = 0;
  int64_t tasks = 0;
  std::string job;  // Slurm's number
};

// Submits these drives' tasks; `drives` is increasing. FailedPrecondition if an earlier submission
// of the same folder is still queued or running; Unavailable if Slurm does not tell, or refuses a
// job; Cancelled. The jobs accepted before go on.
absl::StatusOr<std::vector<SlurmArray>> SubmitToSlurm(const BatchPlan& plan,
                                                      const std::vector<size_t>& drives,
                                                      const SlurmOptions& options);

}  // namespace egosieve::tools
