// egosieve merge DIR FROM...: adds the maps, with their lines, of later pieces of the drive.
// Existing contents of DIR stay; the other folders are only read.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/line_log.h"
#include "tools/run_folder/run_description.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/trajectory_file.h"

namespace egosieve::tools {
namespace {

// Takes over the maps of a later piece of a drive. Pieces differ in their first frame, and so in
// their first picture; each line names the device of its map.

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

// FailedPrecondition unless the run in `source` is another piece of the drive that `description` is
// of.
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

// Links the maps that `target`, whose description is `description`, lacks, and takes over their
// lines; returns the number of frames whose maps were linked. Unavailable if the folders lie on
// different file systems; Cancelled if interrupted.
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
    if (has_line && place->second->has_map() && target.HoldsMaps(*place->second)) {
      continue;
    }
    const bool has_map = line.has_map() && folder.HoldsMaps(line);
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

class MergeCommand : public Command {
 public:
  std::string name() const override { return "merge"; }
  std::string summary() const override { return "Joins a drive that was learnt in pieces."; }
  std::string example() const override {
    return "egosieve segment my.mp4 --out=p1 --to=9999  # pieces that overlap\n"
           "egosieve segment my.mp4 --out=p2 --from=9980\n"
           "egosieve merge p1 p2";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder of the first piece, which gets the maps")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("FROM", sources_,
                   "Runs of the same input that began at later frames, which give the frames after "
                   "its last one")
        ->required()
        ->type_name("")
        ->configurable(false);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder target, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, target.ReadDescription());
    // Check all before writing anything.
    for (const std::string& source : sources_) {
      EGOSIEVE_RETURN_IF_ERROR(CheckPiece(description, source));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::Take(directory_));
    RemoveAbandonedFiles(directory_);
    int64_t taken = 0;
    for (const std::string& source : sources_) {
      EGOSIEVE_ASSIGN_OR_RETURN(const int64_t maps,
                                TakeMaps(target, description, source, progress_));
      taken += maps;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, target.ReadLines());
    EGOSIEVE_RETURN_IF_ERROR(WriteTrajectory(target));
    result_.Tell(name(), {{"run", directory_}, {"maps", taken}},
                 absl::StrFormat("%d maps taken over into %s\n", taken, directory_));
    Warn(DescribeMissingMaps(target, lines));
    return ExitCode::kDone;
  }

 private:
  std::string directory_;
  std::vector<std::string> sources_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeMergeCommand() { return std::make_unique<MergeCommand>(); }

}  // namespace egosieve::tools
