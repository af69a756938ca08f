// How far the drives of a batch are: from the book and the run folders alone, at any time and on
// any machine that sees them. As a table and as a page.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/plan.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

struct DriveStatus {
  std::string state = "not started";  // begun, running, failed, frames failed, done
  int tasks = 0, tasks_done = 0;
  int exit_code = 0;  // of the first task that failed, wholly or in some frames
  int64_t frames = 0, frames_failed = 0;
  double seconds = 0.0;  // of the tasks that were run last
  std::string reason;    // the error's line, if one failed
};

DriveStatus StatusOf(const BatchPlan& plan, size_t drive);
std::vector<DriveStatus> StatusOfAll(const BatchPlan& plan);

// Prints the table of all drives, or {"drives": ..., "page": ...}.
void TellStatus(const BatchPlan& plan, const std::vector<DriveStatus>& drives,
                const ResultFlag& result);

// batch.html in the common parent folder of all run folders. AlreadyExists if no batch has written
// that file.
absl::StatusOr<std::string> FindPage(const BatchPlan& plan);
// Links are relative and lead to existing files. While drives are running, the page reloads itself.
// The same error.
absl::Status WritePage(const BatchPlan& plan, const std::vector<DriveStatus>& drives);

}  // namespace egosieve::tools
