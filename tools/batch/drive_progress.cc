#include "tools/batch/drive_progress.h"

#include <filesystem>
#include <system_error>

#include "kernels/base/status_macros.h"
#include "tools/reconstruct/reconstruct_run.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

absl::Status CountMaps(const RunFolder& folder, const RunDescription& description,
                       DriveProgress& progress) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  progress.frames = static_cast<int64_t>(lines.size());
  for (const FrameLine& line : lines) {
    if (line.outcome == FrameLine::Outcome::kFailed) {
      ++progress.frames_failed;
    } else {
      progress.maps += line.has_map() && folder.HoldsMaps(line, description);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DriveProgress> ReadDriveProgress(const std::string& out) {
  DriveProgress progress;
  const absl::StatusOr<RunFolder> folder = RunFolder::Open(out);
  if (absl::IsNotFound(folder.status())) return progress;
  EGOSIEVE_RETURN_IF_ERROR(folder.status());
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder->ReadDescription());
  progress.state = description.ended;
  progress.reason = description.ended_message;
  progress.finished_utc = description.finished_utc;
  progress.is_segmented = description.ended == "done";
  EGOSIEVE_RETURN_IF_ERROR(CountMaps(*folder, description, progress));
  progress.is_reconstructed = IsReconstructed(*folder);
  std::error_code error;
  progress.has_report = std::filesystem::exists(folder->File("report.html"), error);
  return progress;
}

}  // namespace egosieve::tools
