#include "tools/batch/batch_command.h"

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/batch_flags.h"
#include "tools/batch/drives_run.h"
#include "tools/batch/index_page.h"
#include "tools/cli/child_process.h"
#include "tools/cli/interruption.h"
#include "tools/cli/warning.h"

namespace egosieve::tools {
namespace {

class BatchCommand : public Command {
 public:
  std::string name() const override { return "batch"; }
  std::string summary() const override {
    return "Segments many drives and runs further commands on them, here or as jobs of Slurm; does "
           "what is missing, ends with a table and a page.";
  }
  std::string example() const override {
    return "egosieve batch videos --out=out --jobs=2 --then=reconstruct,masks,render,report\n"
           "egosieve batch 'videos/*.mp4' --out=out --segment_flags='--profile=fast --stride=3'\n"
           "egosieve batch drives.toml --engine=slurm --cpus=4 && egosieve batch drives.toml "
           "--status\n"
           "  # [defaults] with out = \"out\", then = [\"reconstruct\", \"masks\"] and segment's "
           "flags,\n"
           "  # [defaults.masks] with those of masks; then a table per drive, [a] with path = "
           "\"a.mp4\";\n"
           "  # or JSON, a list of {\"path\": ..., \"out\": ..., \"flags\": {...}}";
  }

  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(BatchFlags::Drives drives, flags_.FindEntries());
    if (flags_.plan_run.IsAskedFor()) return flags_.RunPlan(drives.entries);
    EGOSIEVE_RETURN_IF_ERROR(flags_.plan_run.CheckUnplanned(drives.entries));
    const std::string index =
        flags_.index.empty() ? DefaultIndexPath(drives.entries) : flags_.index;
    EGOSIEVE_RETURN_IF_ERROR(CheckIndexPath(index));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string program, OwnProgram());
    if (!drives.left_out.empty()) {
      Warn(absl::StrCat("no drives, and left out: ", absl::StrJoin(drives.left_out, ", ")));
    }
    DrivesRun run(std::move(drives.entries), index);
    run.Run(program, flags_.jobs);
    run.Tell(flags_.result);
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; the same command goes on");
    }
    return run.has_failed() ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  BatchFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeBatchCommand() { return std::make_unique<BatchCommand>(); }

}  // namespace egosieve::tools
