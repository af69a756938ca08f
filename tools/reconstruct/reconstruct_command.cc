#include "tools/reconstruct/reconstruct_command.h"

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/cli/warning.h"
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
           "egosieve reconstruct out/drive --what=masks,probability --resume\n"
           "egosieve reconstruct out/drive --shard=1/2 & "
           "egosieve reconstruct out/drive --shard=2/2";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_,
                   "The run folder; its masks/, ids/, full/ and tracks.csv are written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--what", what_,
                   "What is written, by commas: masks, ids, tracks, objects, probability, "
                   "deviation, class")
        ->capture_default_str()
        ->type_name("WORDS");
    app.add_option("--mask_low", options_.mask.low,
                   "Probability of moving from which a pixel of a mask is moving, where its region "
                   "holds one of --mask_high; others are static")
        ->capture_default_str()
        ->type_name("P");
    app.add_option("--mask_high", options_.mask.high,
                   "Probability that a moving region of a mask holds somewhere")
        ->capture_default_str()
        ->type_name("P");
    app.add_flag("--causal", options_.window.link.causal,
                 "Each frame from itself and the frames before it, as for a live camera");
    app.add_flag("--resume", options_.resume, "Continue where the same command stopped");
    app.add_option("--shard", shard_,
                   "Refines the K-th of N shares of the maps, from 1 on, and writes nothing else: "
                   "a call without --shard then numbers the movers, frame after frame")
        ->type_name("K/N");
    app.add_option("--input", options_.input, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    app.add_option("--static_below", options_.classes.static_below,
                   "Probability of moving below which a pixel's class is static (0)")
        ->type_name("P");
    app.add_option("--dynamic_above", options_.classes.dynamic_above,
                   "Probability of moving above which a pixel's class is dynamic (255)")
        ->type_name("P");
    AddObjectFlags(app, options_.objects);
    range_.AddFlags(app);
    threads_.AddFlag(app);
    device_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(options_.what, ProductChoice::FromText(what_));
    EGOSIEVE_RETURN_IF_ERROR(options_.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(options_.shard, ParseShard(shard_, 1));
    const bool is_share = options_.shard.count > 1;
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, is_share ? FolderLock::Use(folder.path())
                                                              : FolderLock::Take(folder.path()));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, ChooseLines(folder, range_));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, description, lines));
    threads_.Apply();
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(const auto run,
                              ReconstructRun::Open(device.context, folder, lines, options_));
    Progress progress("reconstruct", progress_, run->frames() - run->frames_done_before());
    EGOSIEVE_RETURN_IF_ERROR(run->Run([&] { return progress.AdvanceUninterrupted(); }));
    progress.Finish();
    result_.Tell(name(), {{"run", folder.path()}, {"frames", run->frames()}},
                 absl::StrFormat(is_share ? "the maps of %d frames refined in %s\n"
                                          : "%d frames reconstructed in %s\n",
                                 run->frames(), folder.path()));
    Warn(DescribeMissingMaps(folder, description, lines));
    const auto unreadable = std::count_if(lines.begin(), lines.end(), [](const FrameLine& line) {
      return line.outcome == FrameLine::Outcome::kFailed;
    });
    if (unreadable > 0) {
      Warn(absl::StrCat(unreadable, " frames could not be read and have no mask"));
    }
    return unreadable > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  std::string directory_, shard_, what_ = ProductChoice().ToText();
  ReconstructOptions options_;
  FrameRange range_;
  ThreadsFlag threads_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeReconstructCommand() { return std::make_unique<ReconstructCommand>(); }

}  // namespace egosieve::tools
