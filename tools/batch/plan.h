// The tasks of a batch, for engines that run them on many machines: Slurm, Kubernetes, GNU
// parallel.
//
//   segment            segment PATH --out=OUT
//   following steps, in order: `then` of the drives, else reconstruct and report
//     infer              infer OUT, where segment has --learn_only
//     reconstruct        reconstruct OUT --resume
//     masks, render, report    need reconstruct, where it comes before
//
// If drives are cut into pieces, at most P, these tasks replace segment:
//
//   segment p/P        segment PATH --out=PIECE --from --to; the first piece is OUT, the others are
//                      OUT.pieces/p and begin kOverlapFrames before their cut
//   merge              merge OUT OUT.pieces/2 ..., needs every segment
//
// A drive with fewer pieces has some tasks with nothing to do.
//
// With D drives and S stages, task t (from 0) is stage t / D of drive t mod D. Each stage is a
// range of numbers, in the manifest's order, and a task has a higher number than the tasks that it
// needs. A task that is already done may be run again and only checks; an interrupted task
// continues. A step after segment counts as done if its note says so for this run and these flags
// (drive_files.h).
#ifndef EGOSIEVE_TOOLS_BATCH_PLAN_H_
#define EGOSIEVE_TOOLS_BATCH_PLAN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/drive_progress.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// After so many frames the model of a piece has reached its budget.
inline constexpr int64_t kOverlapFrames = 10;

struct PlanStage {
  std::string command;
  int piece = 0;              // from 1; 0: the drive
  std::string name;           // "segment 2/4"
  std::vector<size_t> needs;  // stages whose task of the same drive must be done before
};

class BatchPlan {
 public:
  // `threads` of each task's program; 0: all of the machine. All drives have the same commands in
  // `then` (CheckThen).
  BatchPlan(std::vector<BatchEntry> entries, int threads);

  const std::vector<BatchEntry>& entries() const { return entries_; }
  const std::vector<PlanStage>& stages() const { return stages_; }
  int threads() const { return threads_; }
  int64_t task_count() const { return static_cast<int64_t>(stages_.size() * entries_.size()); }
  int64_t TaskNumber(size_t stage, size_t drive) const {
    return static_cast<int64_t>(stage * entries_.size() + drive);
  }

  int pieces() const { return pieces_; }  // of the drive with most pieces
  // Frames of the longest piece of a drive, if the longest drive has this many frames.
  int64_t LongestPiece(int64_t longest_drive_frames) const;

  // egosieve's arguments; empty if the drive has no such piece.
  std::vector<std::string> Arguments(size_t stage, size_t drive) const;
  bool IsDone(size_t stage, size_t drive, const DriveProgress& progress) const;
  // Whether notes record that the stage's tasks are done; otherwise the run folder does.
  bool IsNoted(size_t stage) const { return stages_[stage].command != "segment"; }
  absl::Status NoteDone(int64_t task) const;
  // Drives with a task to do, including drives of which that is not known.
  std::vector<size_t> UnfinishedDrives() const;
  // Empty if there is nothing to do. OutOfRange if no task has this number. FailedPrecondition if a
  // task that it needs is not done; the message names the task to run first.
  absl::StatusOr<std::vector<std::string>> ArgumentsOfReadyTask(int64_t task) const;

 private:
  std::vector<std::string> SegmentArguments(int piece, const BatchEntry& entry) const;
  std::vector<std::string> MergeArguments(const BatchEntry& entry) const;
  // The command of a stage after segment, with the flags by which it is noted.
  BatchStep StepOf(size_t stage, size_t drive) const;

  std::vector<BatchEntry> entries_;
  std::vector<PlanStage> stages_;
  int threads_;
  int pieces_ = 1;
};

// The run folder of a drive's piece; pieces count from 1.
std::string PieceFolder(const BatchEntry& entry, int piece);

// InvalidArgument if a drive with cuts has flags of segment that choose frames or leave out maps.
absl::Status CheckCuts(const std::vector<BatchEntry>& entries);

// InvalidArgument if drives differ in the commands that follow.
absl::Status CheckThen(const std::vector<BatchEntry>& entries);

// Replaces this process by `program` with these arguments. Returns only if that fails or if the
// process was asked to stop.
absl::Status BecomeProgram(const std::string& program, std::vector<std::string> arguments);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_PLAN_H_
