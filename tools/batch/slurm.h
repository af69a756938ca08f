// Runs a batch's plan by Slurm: one job array per stage, in which drive d is element d.
//
// Each array depends, element by element (aftercorr), on the arrays of the stages that it needs: a
// drive continues as soon as its own tasks are done, and a failing drive stops no other. If a node
// fails or a time limit is reached, the task is queued again (--requeue, --signal). A task gets
// SIGTERM a minute before its limit and ends with complete files; its next start continues from
// there.
//
// Files in the jobs' folder: drives.json, the batch as submitted, and a script and logs for each array.
// The jobs' names end in a text of the folder, by which Slurm itself tells which of them are
// queued, also those of a submission that was killed.
//
// Time and memory to ask for are measured on the first frames of one drive on this machine:
//
//   (TC1)  seconds per frame of a stage = seconds of its task on a piece / frames of the piece
//
// (TC1) includes the time that a task needs before its first frame, so a long drive takes less than
// (TC1) predicts. The model reaches its budget within ten frames, and memory does not grow with a
// drive's length, so a short piece is enough.
#ifndef EGOSIEVE_TOOLS_BATCH_SLURM_H_
#define EGOSIEVE_TOOLS_BATCH_SLURM_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/plan.h"

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

struct BatchCost {
  std::map<std::string, double> seconds_per_frame;  // by command
  int64_t peak_memory_bytes = 0;                    // resident, of the largest task
  int64_t measured_frames = 0;
  int64_t longest_drive_frames = 0;  // according to the inputs' headers
};

// Inspects every drive, and runs the stages on the first `frames` frames of the drive with the
// largest pictures, in `scratch`, a folder that is removed before and after. Errors: no drive can
// be read, or a stage fails; Cancelled if interrupted.
absl::StatusOr<BatchCost> MeasureCost(const BatchPlan& plan, const std::string& program,
                                      const std::string& scratch, int64_t frames);

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

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_SLURM_H_
