#include "tools/infer/map_target.h"

#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/former_run.h"
#include "tools/segment/drive_writer.h"

namespace egosieve::tools {

absl::Status MapTarget::CheckApartFrom(const vision::FrameSource& frames) const {
  if (is_run()) return absl::OkStatus();
  std::error_code error;
  if (std::filesystem::equivalent(out, run, error)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--out=", out, " is the run itself; leave --out away to make its maps there"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckApart(out, {run}));
  EGOSIEVE_RETURN_IF_ERROR(CheckApart(out, frames.files()));
  if (CheckApart(run, {out}).ok()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--out=", out, " lies in the run; choose a folder outside of it"));
}

absl::StatusOr<MapBook> MapTarget::Open(const RunFolder& folder, const RunDescription& description,
                                        int stride_pixels, const std::string& device) const {
  if (is_run()) return MapBook::Open(folder, description, device);
  RunDescription maps = description;
  maps.device = device;
  maps.maps_from = AbsolutePath(run);
  maps.grid.stride = stride_pixels;
  const std::map<std::string, std::string> flags = {
      {"stride", absl::StrCat(stride_pixels)}, {"learn_only", "no"}, {"every", "1"}};
  for (const auto& [name, value] : flags) maps.flags[name] = value;
  maps.ended = RunDescription().ended;
  maps.ended_message.clear();
  maps.seconds = 0.0;
  maps.started_utc = UtcNow();
  maps.finished_utc.clear();
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder target, OpenOut(maps));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription held, target.ReadDescription());
  return MapBook::Open(target, held, device);
}

absl::StatusOr<RunFolder> MapTarget::OpenOut(const RunDescription& description) const {
  absl::StatusOr<RunFolder> folder = RunFolder::Open(out);
  if (folder.ok() && !overwrite) {
    EGOSIEVE_ASSIGN_OR_RETURN(RunDescription before, folder->ReadDescription());
    before.device = description.device;
    const std::string difference = DescribeDifference(before, description);
    if (difference.empty()) return folder;
    return absl::AlreadyExistsError(absl::StrCat("the folder ", out,
                                                 " holds another run: ", difference,
                                                 "; choose another for --out, or add --overwrite"));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(folder, RunFolder::Create(out, overwrite));
  EGOSIEVE_RETURN_IF_ERROR(folder->WriteDescription(description));
  return folder;
}

absl::Status MapTarget::TellEnd(const absl::StatusOr<bool>& finished, double seconds) const {
  if (is_run()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(out));
  EGOSIEVE_ASSIGN_OR_RETURN(RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  description.ended = !finished.ok() ? "failed" : *finished ? "done" : "interrupted";
  description.ended_message = std::string(finished.status().message());
  description.frames_answered = description.frames_learnt = description.frames_failed = 0;
  for (const FrameLine& line : lines) {
    const bool failed = line.outcome == FrameLine::Outcome::kFailed;
    description.frames_failed += failed;
    description.frames_answered += !failed && line.has_map();
    description.frames_learnt += line.outcome == FrameLine::Outcome::kLearnt;
  }
  description.seconds += seconds;
  description.finished_utc = UtcNow();
  return folder.WriteDescription(description);
}

}  // namespace egosieve::tools
