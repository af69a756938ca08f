// How far the drives of a batch are: from the book and the run folders alone, at any time and on
// any machine that sees them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/batch/plan.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

struct DriveStatus {
  std::string state = "not started";  // begun, failed, frames failed, done
  int tasks = 0, tasks_done = 0;
  int exit_code = 0;  // of the first task that failed, wholly or in some frames
  int64_t frames = 0, frames_failed = 0;
  double seconds = 0.0;  // of the tasks that were run last
  std::string reason;    // the error's line, if one failed
};

DriveStatus StatusOf(const BatchPlan& plan, size_t drive);
std::vector<DriveStatus> StatusOfAll(const BatchPlan& plan);

// Prints the table of all drives, or {"drives": ...}.
void TellStatus(const BatchPlan& plan, const std::vector<DriveStatus>& drives,
                const ResultFlag& result);

}  // namespace egosieve::tools
