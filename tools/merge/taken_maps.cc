#include "tools/merge/taken_maps.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/line_log.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The first frame that `segment` was asked for.
std::string BeginIn(const RunDescription& description) {
  const auto from = description.flags.find("from");
  return from == description.flags.end() ? "" : from->second;
}

// Length of the input in frames: the end of its fingerprint.
std::string LengthIn(const RunDescription& description) {
  const std::string& text = description.input.fingerprint;
  return text.substr(std::min(text.find('-'), text.size()));
}

// The files are one on the disk afterwards; each folder may be removed.
absl::Status LinkMaps(const RunFolder& from, const RunFolder& to, int64_t index) {
  for (const MapFile& file : kMapFiles) {
    const std::string map = from.FrameFile(file.folder, index, file.suffix);
    const std::string link = to.FrameFile(file.folder, index, file.suffix);
    std::error_code error;
    if (!fs::exists(map, error)) continue;  // a run without deviations
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(to.File(file.folder)));
    fs::remove(link, error);  // of a map that is not whole
    fs::create_hard_link(map, link, error);
    if (error) {
      return absl::UnavailableError(
          absl::StrCat("cannot link ", map, " as ", link, ": ", error.message(),
                       "; the pieces must lie on one file system, and one that has links"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckPiece(const RunDescription& description, const std::string& source) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(source));
  EGOSIEVE_ASSIGN_OR_RETURN(RunDescription other, folder.ReadDescription());
  std::string difference;
  if (BeginIn(other) == BeginIn(description)) {
    difference = absl::StrCat("both begin at frame ", BeginIn(description));
  } else {
    other.device = description.device;
    other.flags["from"] = BeginIn(description);
    if (LengthIn(other) == LengthIn(description)) {
      other.input.fingerprint = description.input.fingerprint;
    }
    difference = DescribeDifference(description, other);
  }
  if (difference.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(source, " is no later piece of the drive: ", difference,
                   "; give runs of the same input with the same flags that begin at later frames"));
}

absl::StatusOr<int64_t> TakeMaps(const RunFolder& target, const RunDescription& description,
                                 const std::string& source, const ProgressFlag& flag) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(source));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription other, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadLines());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> there, target.ReadLines());
  std::map<int64_t, const FrameLine*> by_index;
  for (const FrameLine& line : there) by_index[line.index] = &line;
  std::optional<LineLog> log;
  Progress progress("merge", flag, static_cast<int64_t>(lines.size()));
  int64_t taken = 0;
  for (FrameLine& line : lines) {
    progress.Advance();
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; the same command goes on");
    }
    const auto place = by_index.find(line.index);
    const bool has_line = place != by_index.end();
    if (has_line && place->second->has_map() && target.HoldsMaps(*place->second, description)) {
      continue;
    }
    const bool has_map = line.has_map() && folder.HoldsMaps(line, other);
    if (!has_map && has_line) continue;
    if (has_map) {
      EGOSIEVE_RETURN_IF_ERROR(LinkMaps(folder, target, line.index));
      ++taken;
    } else {
      line.width_pixels = line.height_pixels = 0;
    }
    if (line.map_device.empty() && other.device != description.device) {
      line.map_device = other.device;
    }
    if (!log.has_value()) {
      EGOSIEVE_ASSIGN_OR_RETURN(log, target.OpenMapLog());
    }
    EGOSIEVE_RETURN_IF_ERROR(log->Append(ToText(line)));
  }
  progress.Finish();
  return taken;
}

}  // namespace egosieve::tools
