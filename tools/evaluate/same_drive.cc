#include "tools/evaluate/same_drive.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "tools/segment/drive_input.h"

namespace egosieve::tools {

namespace fs = std::filesystem;

absl::Status CheckSameDrive(const std::string& whose, const std::string& frames,
                            const std::string& fingerprint, int64_t from,
                            const std::string& truth) {
  fs::path path = fs::absolute(truth).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  std::error_code error;
  for (const fs::path& beside : {path / "frames", path.parent_path() / "frames"}) {
    if (!fs::is_directory(beside, error)) continue;
    if (fs::equivalent(beside, frames, error)) return absl::OkStatus();
    const absl::StatusOr<DriveInput> input = OpenDriveInput(beside.string(), from);
    if (input.ok() && input->description.fingerprint == fingerprint) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat(whose, " is of ", frames, ", the truth ", truth, " of ", beside.string(),
                     ", which are other frames; give the truth of this drive"));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
