#include "tools/merge/merge_command.h"

#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/merge/taken_maps.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/former_run.h"
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
      EGOSIEVE_ASSIGN_OR_RETURN(const int64_t maps,
                                TakeMaps(target, description, source, progress_));
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
  std::string directory_;
  std::vector<std::string> sources_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeMergeCommand() { return std::make_unique<MergeCommand>(); }

}  // namespace egosieve::tools
