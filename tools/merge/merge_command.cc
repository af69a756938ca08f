#include "tools/merge/merge_command.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
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
