#include "tools/merge/merge_command.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/line_log.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/trajectory_file.h"

namespace egosieve::tools {
namespace {

class MergeCommand : public Command {
 public:
  std::string name() const override { return "merge"; }
  std::string summary() const override {
    return "Takes over maps of copies of a run folder, or of later pieces of the drive.";
  }
  std::string example() const override {
    return "egosieve infer copy1 --shard=1/2   # on one machine\n"
           "egosieve infer copy2 --shard=2/2   # on another\n"
           "egosieve merge out/drive copy1 copy2\n"
           "egosieve segment my.mp4 --out=p1 --to=9999       # or learn in pieces that overlap\n"
           "egosieve segment my.mp4 --out=p2 --from=9980\n"
           "egosieve merge p1 p2";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder that gets the maps")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("FROM", sources_,
                   "Copies of it, with maps of other frames; or runs of the same input that began "
                   "at later frames, which give the frames after its last one")
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
    bool has_pieces = false;
    for (const std::string& source : sources_) {
      EGOSIEVE_ASSIGN_OR_RETURN(const bool is_piece, CheckSource(description, source));
      has_pieces |= is_piece;
    }
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(target.File("grid")));
    RemoveAbandonedFiles(directory_);
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::Use(directory_));
    int64_t taken = 0;
    for (const std::string& source : sources_) {
      EGOSIEVE_ASSIGN_OR_RETURN(const int64_t maps, TakeOver(target, description, source));
      taken += maps;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, target.ReadLines());
    if (has_pieces) EGOSIEVE_RETURN_IF_ERROR(WriteTrajectory(target));
    result_.Tell(name(), {{"run", directory_}, {"maps", taken}},
                 absl::StrFormat("%d maps taken over into %s\n", taken, directory_));
    Warn(DescribeMissingMaps(target, description, lines));
    return ExitCode::kDone;
  }

 private:
  // Copies differ in path and device of the maps, which each line names; pieces differ in their
  // first frame, and so in their first picture. Returns whether it is a piece.
  static absl::StatusOr<bool> CheckSource(const RunDescription& description,
                                          const std::string& source) {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(source));
    EGOSIEVE_ASSIGN_OR_RETURN(RunDescription other, folder.ReadDescription());
    other.device = description.device;
    other.maps_from = description.maps_from;
    const bool is_piece = IsPiece(description, other);
    if (is_piece) {
      other.flags["from"] = description.flags.at("from");
      if (LengthIn(other) == LengthIn(description)) {
        other.input.fingerprint = description.input.fingerprint;
      }
    } else {
      other.input.path = description.input.path;
    }
    const std::string difference = DescribeDifference(description, other);
    if (difference.empty()) return is_piece;
    return absl::FailedPreconditionError(
        is_piece ? absl::StrCat(source, " is no piece of the drive: ", difference,
                                "; give runs of the same input with the same flags")
                 : absl::StrCat(source, " is no copy of the run: ", difference,
                                "; give folders of the same run"));
  }

  static bool IsPiece(const RunDescription& description, const RunDescription& other) {
    const auto from = description.flags.find("from"), later = other.flags.find("from");
    return from != description.flags.end() && later != other.flags.end() &&
           from->second != later->second;
  }

  // Length of the input in frames: the end of its fingerprint.
  static std::string LengthIn(const RunDescription& description) {
    const std::string& text = description.input.fingerprint;
    return text.substr(std::min(text.find('-'), text.size()));
  }

  absl::StatusOr<int64_t> TakeOver(const RunFolder& target, const RunDescription& description,
                                   const std::string& source) const {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(source));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription other, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadLines());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> there, target.ReadLines());
    std::map<int64_t, const FrameLine*> by_index;
    for (const FrameLine& line : there) by_index[line.index] = &line;
    std::optional<LineLog> log;
    Progress progress("merge", progress_, static_cast<int64_t>(lines.size()));
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
        EGOSIEVE_RETURN_IF_ERROR(CopyMaps(folder, target, line.index));
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

  static absl::Status CopyMaps(const RunFolder& from, const RunFolder& to, int64_t index) {
    for (const MapFile& file : kMapFiles) {
      const absl::StatusOr<std::string> png =
          ReadFile(from.FrameFile(file.folder, index, file.suffix));
      if (absl::IsNotFound(png.status())) continue;  // a run without a deviation or potential
      EGOSIEVE_RETURN_IF_ERROR(png.status());
      EGOSIEVE_RETURN_IF_ERROR(CreateFolder(to.File(file.folder)));
      EGOSIEVE_RETURN_IF_ERROR(
          WriteFileAtomically(to.FrameFile(file.folder, index, file.suffix), *png));
    }
    return absl::OkStatus();
  }

  std::string directory_;
  std::vector<std::string> sources_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeMergeCommand() { return std::make_unique<MergeCommand>(); }

}  // namespace egosieve::tools
