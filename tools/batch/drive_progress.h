// Progress of a drive's tasks, read only from its run folder: any machine that sees the folder can
// read it, whatever engine runs the tasks.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_PROGRESS_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_PROGRESS_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct DriveProgress {
  std::string state = "not started";  // of segment: run.json's `ended`
  std::string reason;                 // the error's line, if it failed
  std::string finished_utc;           // when segment ended
  int64_t frames = 0;                 // frames with a line
  int64_t frames_failed = 0;
  int64_t maps = 0;
  bool is_segmented = false;
  bool is_reconstructed = false;
  bool has_report = false;
};

// A folder without a run is a drive that has not started. Errors: a run that cannot be read.
absl::StatusOr<DriveProgress> ReadDriveProgress(const std::string& out);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_PROGRESS_H_
