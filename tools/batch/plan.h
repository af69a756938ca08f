// The tasks of a batch, for engines that run them on many machines: Slurm, Kubernetes, GNU
// parallel.
//
//   stage           its task of a drive                        needs, of the same drive
//   segment         segment PATH --out=OUT --learn_only        -
//   infer K/N       infer OUT --shard=K/N                      segment
//   reconstruct     reconstruct OUT                            every infer
//   report          report OUT                                 reconstruct
//
// Of D drives and S stages, task t (from 0) is stage t / D of drive t mod D: each stage is a range
// of numbers, in the manifest's order, and what a task needs has a lower number. A task that is
// done may be run again and does nothing but look; one that was cut off goes on.
#ifndef EGOSIEVE_TOOLS_BATCH_PLAN_H_
#define EGOSIEVE_TOOLS_BATCH_PLAN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/batch/drive_progress.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

enum class StageKind { kSegment, kInfer, kReconstruct, kReport };

struct PlanStage {
  StageKind kind = StageKind::kSegment;
  int shard = 0;              // of kInfer, from 0
  std::string name;           // "infer 2/4"
  std::vector<size_t> needs;  // stages whose task of the same drive must be done before
};

class BatchPlan {
 public:
  // `shards` of each drive's maps, at least 1; `threads` of each task's program, 0: the machine's.
  BatchPlan(std::vector<BatchEntry> entries, int shards, int threads);

  const std::vector<BatchEntry>& entries() const { return entries_; }
  const std::vector<PlanStage>& stages() const { return stages_; }
  int shards() const { return shards_; }
  int threads() const { return threads_; }
  int64_t task_count() const { return static_cast<int64_t>(stages_.size() * entries_.size()); }
  int64_t TaskNumber(size_t stage, size_t drive) const {
    return static_cast<int64_t>(stage * entries_.size() + drive);
  }

  // egosieve's arguments.
  std::vector<std::string> Arguments(size_t stage, size_t drive) const;
  bool IsDone(size_t stage, const DriveProgress& progress) const;
  // Drives with a task to do; those of which that cannot be told count among them.
  std::vector<size_t> UnfinishedDrives() const;
  // OutOfRange for a number that is no task's; FailedPrecondition, naming the task to run first,
  // where one that it needs is not done.
  absl::StatusOr<std::vector<std::string>> ArgumentsOfReadyTask(int64_t task) const;

 private:
  std::vector<BatchEntry> entries_;
  std::vector<PlanStage> stages_;
  int shards_;
  int threads_;
};

// Becomes `program` with these arguments; returns only where that fails, or where the process was
// asked to stop.
absl::Status BecomeProgram(const std::string& program, std::vector<std::string> arguments);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_PLAN_H_
