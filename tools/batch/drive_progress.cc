#include "tools/batch/drive_progress.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/infer/shard.h"
#include "tools/reconstruct/reconstruct_run.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

absl::Status CountMaps(const RunFolder& folder, const RunDescription& description, int shards,
                       DriveProgress& progress) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  progress.frames = static_cast<int64_t>(lines.size());
  const auto flag = description.flags.find("checkpoint_every");
  int64_t checkpoint_every = 0;
  if (flag == description.flags.end() || !absl::SimpleAtoi(flag->second, &checkpoint_every)) {
    checkpoint_every = 0;
  }
  std::vector<Shard> parts;
  for (int shard = 0; shard < shards; ++shard) {
    EGOSIEVE_ASSIGN_OR_RETURN(const Shard part,
                              ParseShard(absl::StrCat(shard + 1, "/", shards), checkpoint_every));
    parts.push_back(part);
  }
  for (const FrameLine& line : lines) {
    if (line.outcome == FrameLine::Outcome::kFailed) {
      ++progress.frames_failed;
    } else if (line.has_map() && folder.HoldsMaps(line, description)) {
      ++progress.maps;
    } else {
      for (int shard = 0; shard < shards; ++shard) {
        if (parts[shard].Contains(line.index)) ++progress.missing_maps[shard];
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DriveProgress> ReadDriveProgress(const std::string& out, int shards) {
  DriveProgress progress;
  progress.missing_maps.resize(shards, 0);
  const absl::StatusOr<RunFolder> folder = RunFolder::Open(out);
  if (absl::IsNotFound(folder.status())) return progress;
  EGOSIEVE_RETURN_IF_ERROR(folder.status());
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder->ReadDescription());
  progress.state = description.ended;
  progress.reason = description.ended_message;
  progress.finished_utc = description.finished_utc;
  progress.is_segmented = description.ended == "done";
  EGOSIEVE_RETURN_IF_ERROR(CountMaps(*folder, description, shards, progress));
  progress.is_reconstructed = IsReconstructed(*folder);
  std::error_code error;
  progress.has_report = std::filesystem::exists(folder->File("report.html"), error);
  return progress;
}

}  // namespace egosieve::tools
