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
// With D drives and S stages, task t (from 0) is stage t / D of drive t mod D; it needs only tasks
// of its drive with lower numbers. A task that is done may be run again and only checks; an
// interrupted one continues.
//
// The book: a record per task that has ended, egosieve_logs/NAME/STAGE.json beside the run folder
// OUT = .../NAME. It says how the task ended and its key: its arguments, and the keys of the tasks
// that it needs, down to when segment ended. Tasks of one drive may run on several machines, so each
// writes a file of its own, whole or not at all. segment is done where its run.json says so; any
// other task if its record has the present key, and its product is there.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/batch/drives.h"

namespace egosieve::tools {

// After so many frames the model of a piece has reached its budget.
inline constexpr int64_t kOverlapFrames = 10;

struct BatchTask {
  std::string stage;                   // "segment_2"
  std::string folder;                  // the run folder that it works on
  std::vector<std::string> arguments;  // of egosieve; empty: the drive has no such piece
  std::vector<size_t> needs;           // tasks, by number
};

struct TaskRecord {
  std::string key;
  int exit_code = 0;
  double seconds = 0.0;
  std::string reason;  // the error's line, if it failed

  // All is done, or all but some frames.
  bool is_good() const;
};

class BatchPlan {
 public:
  // Paths are absolute. InvalidArgument if drives differ in what follows segment, or two have one
  // run folder.
  static absl::StatusOr<BatchPlan> Create(std::vector<BatchDrive> drives);

  // As JSON, for tasks on other machines. InvalidArgument for what is no plan.
  nlohmann::ordered_json ToJson() const;
  std::string ToText() const;
  static absl::StatusOr<BatchPlan> FromText(const std::string& text);

  const std::vector<BatchDrive>& drives() const { return drives_; }
  const std::vector<BatchTask>& tasks() const { return tasks_; }
  size_t stages() const { return tasks_.size() / drives_.size(); }
  size_t Number(size_t stage, size_t drive) const { return stage * drives_.size() + drive; }
  const BatchDrive& DriveOf(size_t task) const { return drives_[task % drives_.size()]; }

  bool IsDone(size_t task) const;
  // How the task ended; absent if it never ran, or was cut off when it ran last.
  std::optional<TaskRecord> Record(size_t task) const;

  // Runs the task in a process of its own and enters its end in the book; its exit code, 130 if it
  // was interrupted. A task that is done, or has nothing to do, is left, except segment, which
  // checks itself. to_log: its output goes to egosieve_logs/NAME/STAGE.log. Unavailable if the
  // process cannot be started, or if nobody knows how it ended; then it is not done.
  absl::StatusOr<int> Run(size_t task, const std::string& program, bool to_log,
                          const std::function<bool()>& stop_requested) const;

 private:
  // null if a segment is not done.
  nlohmann::ordered_json Key(size_t task) const;
  std::string BookPath(size_t task, const char* suffix) const;

  std::vector<BatchDrive> drives_;  // of a plan that was read, paths and run folders alone
  std::vector<BatchTask> tasks_;
};

// Beside the run folder `out`: its records and logs, and the masks.
std::string BookFolder(const std::string& out);
std::string MasksPath(const std::string& out);

}  // namespace egosieve::tools
