// Costs of a drive's tasks, measured on the first frames of one drive on this machine.
//
//   (TC1)  seconds per frame of a stage = seconds of its task on a piece / frames of the piece
//
// (TC1) includes the time that a task needs before its first frame, so a long drive takes less than
// (TC1) predicts. The model reaches its budget within ten frames, and memory does not grow with a
// drive's length, so a short piece is enough.
#ifndef EGOSIEVE_TOOLS_BATCH_TASK_COST_H_
#define EGOSIEVE_TOOLS_BATCH_TASK_COST_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "tools/batch/plan.h"

namespace egosieve::tools {

struct BatchCost {
  std::map<std::string, double> seconds_per_frame;  // by command
  int64_t peak_memory_bytes = 0;                    // resident, of the largest task
  int64_t measured_frames = 0;
  int64_t longest_drive_frames = 0;  // according to the inputs' headers
};

// Inspects every drive, and runs the stages on the first `frames` frames of the drive with the
// largest pictures, in `scratch`, a folder that is removed before and after. Errors: no drive can
// be read, or a stage fails, with the path of its log.
absl::StatusOr<BatchCost> MeasureCost(const std::string& program, const BatchPlan& plan,
                                      const std::string& scratch, int64_t frames);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_TASK_COST_H_
