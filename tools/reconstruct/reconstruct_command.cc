#include "tools/reconstruct/reconstruct_command.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/cli/warning.h"
#include "tools/reconstruct/reconstruct_flags.h"
#include "tools/reconstruct/reconstruct_run.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

class ReconstructCommand : public Command {
 public:
  std::string name() const override { return "reconstruct"; }
  std::string summary() const override {
    return "Turns a run's maps into masks that follow the picture's edges, numbered movers and "
           "tracks.";
  }
  std::string example() const override {
    return "egosieve reconstruct out/drive\n"
           "egosieve reconstruct out/drive --what=masks,probability --resume";
  }

  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const ReconstructOptions options, flags_.MakeOptions());
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(flags_.directory));
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::Take(folder.path()));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines,
                              ChooseLines(folder, flags_.range));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, description, lines));
    flags_.threads.Apply();
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, flags_.device.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(const auto run,
                              ReconstructRun::Open(device.context, folder, lines, options));
    Progress progress("reconstruct", flags_.progress, run->frames() - run->frames_done_before());
    EGOSIEVE_RETURN_IF_ERROR(run->Run([&] { return progress.AdvanceUninterrupted(); }));
    progress.Finish();
    flags_.result.Tell(
        name(), {{"run", folder.path()}, {"frames", run->frames()}},
        absl::StrFormat("%d frames reconstructed in %s\n", run->frames(), folder.path()));
    Warn(DescribeMissingMaps(folder, lines));
    const auto unreadable = std::count_if(lines.begin(), lines.end(), [](const FrameLine& line) {
      return line.outcome == FrameLine::Outcome::kFailed;
    });
    if (unreadable > 0) {
      Warn(absl::StrCat(unreadable, " frames could not be read and have no mask"));
    }
    return unreadable > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  ReconstructFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeReconstructCommand() { return std::make_unique<ReconstructCommand>(); }

}  // namespace egosieve::tools
