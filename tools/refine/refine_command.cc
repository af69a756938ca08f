// egosieve refine DIR: masks, numbers and tracks of movers (frame_products.h).
// Errors of usage, of the run folder, of the input and of the environment; Cancelled, with whole
// chunks so far.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/progress.h"
#include "tools/cli/warning.h"
#include "tools/refine/refine_run.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

class RefineCommand : public Command {
 public:
  std::string name() const override { return "refine"; }
  std::string summary() const override {
    return "Turns a run's maps into masks that follow the picture's edges, numbered movers and "
           "tracks; formerly reconstruct, a name that still works.";
  }
  std::string example() const override {
    return "egosieve refine out/drive\n"
           "egosieve refine out/drive --what=masks,probability --resume";
  }

  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }

  absl::StatusOr<ExitCode> Run() override { return RunRefine(flags_); }

 private:
  RefineFlags flags_;
};

}  // namespace

void RefineFlags::AddFlags(CLI::App& app) {
  app.add_option("DIR", directory,
                 "The run folder; its masks/, ids/, full/ and tracks.csv are written")
      ->required()
      ->type_name("")
      ->configurable(false);
  app.add_option("--what", what,
                 "What is written, by commas: masks, ids, tracks, objects, probability, "
                 "deviation, class")
      ->capture_default_str()
      ->type_name("WORDS");
  app.add_option("--mask_low", options.mask.low,
                 "Probability of moving from which a pixel of a mask is moving, where its region "
                 "holds one of --mask_high; others are static")
      ->capture_default_str()
      ->type_name("P");
  app.add_option("--mask_high", options.mask.high,
                 "Probability that a moving region of a mask holds somewhere")
      ->capture_default_str()
      ->type_name("P");
  app.add_flag("--causal", options.window.link.causal,
               "Each frame from itself and the frames before it, as for a live camera");
  app.add_flag("--resume", options.resume,
               "Continue where the same command stopped; start it where there is none");
  app.add_option("--input", options.input, "Where the run's input is now, if it was moved")
      ->type_name("PATH");
  app.add_option("--static_below", options.classes.static_below,
                 "Probability of moving below which a pixel's class is static (0)")
      ->type_name("P");
  app.add_option("--dynamic_above", options.classes.dynamic_above,
                 "Probability of moving above which a pixel's class is dynamic (255)")
      ->type_name("P");
  AddObjectFlags(app, options.objects);
  range.AddFlags(app);
  threads.AddFlag(app);
  progress.AddFlag(app);
  result.AddFlag(app);
}

absl::StatusOr<ExitCode> RunRefine(const RefineFlags& flags) {
  RefineOptions options = flags.options;
  EGOSIEVE_ASSIGN_OR_RETURN(options.what, ProductChoice::FromText(flags.what));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(flags.directory));
  EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::Take(folder.path()));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, ChooseLines(folder, flags.range));
  EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, lines));
  flags.threads.Apply();
  EGOSIEVE_ASSIGN_OR_RETURN(const auto run, RefineRun::Open(folder, lines, options));
  Progress progress("refine", flags.progress, run->frames() - run->frames_done_before());
  EGOSIEVE_RETURN_IF_ERROR(run->Run([&] { return progress.AdvanceUninterrupted(); }));
  progress.Finish();
  flags.result.Tell("refine", {{"run", folder.path()}, {"frames", run->frames()}},
                    absl::StrFormat("%d frames refined in %s\n", run->frames(), folder.path()));
  Warn(DescribeMissingMaps(folder, lines));
  const auto unreadable = std::count_if(lines.begin(), lines.end(), [](const FrameLine& line) {
    return line.outcome == FrameLine::Outcome::kFailed;
  });
  if (unreadable > 0) {
    Warn(absl::StrCat(unreadable, " frames could not be read and have no mask"));
  }
  return unreadable > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
}

std::unique_ptr<Command> MakeRefineCommand() { return std::make_unique<RefineCommand>(); }

}  // namespace egosieve::tools
