// The numbered tasks of a batch, and the book of what is done. This machine's own threads run them,
// or Slurm, Kubernetes, GNU parallel on many machines.
//
//   segment                      segment PATH --out=OUT
//   refine, masks, ...           `then` of the drives, in order; all need segment, and those after
//                                refine need it, too
//
// If drives are cut into pieces, at most P, these tasks replace segment:
//
//   segment_p          segment PATH --out=PIECE --from --to; the first piece is OUT, the others are
//                      OUT.pieces/p and begin kOverlapFrames before their cut
//   merge              merge OUT OUT.pieces/2 ..., needs every segment
//
// A drive with fewer pieces has some tasks with nothing to do.
//
// With D drives and S stages, task t (from 0) is stage t / D of drive t mod D. Each stage is a
// range of numbers, in the manifest's order, and a task has a higher number than the tasks that it
// needs. A task that is done may be run again and only checks; an interrupted one continues.
//
// The book: a record per task, egosieve_logs/NAME/STAGE.json beside the run folder OUT = .../NAME.
// It says how the task ended, for which end of segment and with which flags. Tasks of one drive may
// run on several machines, so each writes a file of its own, whole or not at all. segment is done
// where its run.json says so; any other task if its record says so for the present run and flags,
// and its product is there.
#ifndef EGOSIEVE_TOOLS_BATCH_PLAN_H_
#define EGOSIEVE_TOOLS_BATCH_PLAN_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/batch/manifest.h"
#include "tools/cli/exit_code.h"

namespace egosieve::tools {

// After so many frames the model of a piece has reached its budget.
inline constexpr int64_t kOverlapFrames = 10;

struct PlanStage {
  std::string command;
  int piece = 0;              // from 1; 0: the drive
  std::string name;           // "segment_2"
  std::vector<size_t> needs;  // stages whose task of the same drive must be done before
};

struct TaskRecord {
  static constexpr int kBegun = -1;  // and not ended, as far as is known

  std::string key;  // for which end of segment and with which flags
  int exit_code = kBegun;
  double seconds = 0.0;
  std::string reason;  // the error's line, if it failed

  bool is_good() const {
    return exit_code == static_cast<int>(ExitCode::kDone) ||
           exit_code == static_cast<int>(ExitCode::kFramesFailed);
  }
};

class BatchPlan {
 public:
  // Paths become absolute. InvalidArgument if drives differ in the commands that follow, or if a
  // drive with cuts has flags of segment that choose frames.
  static absl::StatusOr<BatchPlan> Create(std::vector<BatchEntry> entries);

  const std::vector<BatchEntry>& entries() const { return entries_; }
  const std::vector<PlanStage>& stages() const { return stages_; }
  int64_t task_count() const { return static_cast<int64_t>(stages_.size() * entries_.size()); }
  int64_t TaskNumber(size_t stage, size_t drive) const {
    return static_cast<int64_t>(stage * entries_.size() + drive);
  }

  // egosieve's arguments; empty if the drive has no such piece.
  std::vector<std::string> Arguments(size_t stage, size_t drive) const;

  bool IsDone(size_t stage, size_t drive) const;
  // Drives with a task to do.
  std::vector<size_t> UnfinishedDrives() const;
  // A task that this one needs and that is not done.
  std::optional<size_t> MissingStage(size_t stage, size_t drive) const;
  // How the task ended when it was run last; absent if it never ran.
  std::optional<TaskRecord> Record(size_t stage, size_t drive) const;

  // Runs the task in a process of its own and enters its end in the book; its exit code. A task
  // that is done, or has nothing to do, is left, except segment, which checks itself. to_log: its
  // output goes to egosieve_logs/NAME/STAGE.log. Unavailable if the process cannot be started, or
  // if nobody knows how it ended; then it is not done.
  absl::StatusOr<int> Run(size_t stage, size_t drive, const std::string& program, bool to_log,
                          const std::function<bool()>& stop_requested) const;

 private:
  explicit BatchPlan(std::vector<BatchEntry> entries);
  std::vector<std::string> SegmentArguments(int piece, const BatchEntry& entry) const;
  // For which run and with which flags a record holds; empty if segment is not done.
  std::string Key(size_t stage, size_t drive) const;
  absl::Status Enter(size_t stage, size_t drive, const TaskRecord& record) const;
  std::string BookPath(size_t stage, size_t drive, const char* suffix) const;

  std::vector<BatchEntry> entries_;
  std::vector<PlanStage> stages_;
};

// The run folder of a drive's piece; pieces count from 1.
std::string PieceFolder(const BatchEntry& entry, int piece);
// Beside the run folder: its records and logs, and the masks.
std::string BookFolder(const BatchEntry& entry);
std::string MasksPath(const BatchEntry& entry);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_PLAN_H_
