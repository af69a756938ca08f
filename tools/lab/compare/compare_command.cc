#include "tools/lab/compare/compare_command.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/lab/compare/compare_flags.h"
#include "tools/lab/compare/compare_run.h"
#include "tools/lab/compare/comparison_figures.h"
#include "tools/lab/compare/profile_comparison.h"
#include "tools/plots/plots_flag.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

class CompareCommand : public Command {
 public:
  std::string name() const override { return "compare"; }
  std::string summary() const override {
    return "Compares the segmenter with other methods on the same features, frames and pixels.";
  }
  std::string example() const override {
    return "egosieve lab compare drive/frames --truth=drive/masks --out=out/compare\n"
           "egosieve lab compare sequences --out=out/compare --profile=paper\n"
           "egosieve lab compare sequences --out=out/compare --profiles=paper "
           "--variant='no_filter_3=--profile=paper --consistency_filter=off'\n"
           "egosieve lab compare --scenarios=street,junction --frames=60 --out=out/compare";
  }

  void AddFlags(CLI::App& app) override {
    flags_.AddFlags(app);
    device_.AddFlag(app);
    plots_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const CompareOptions options, flags_.MakeOptions());
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<ProfileComparison> comparisons,
                              RunComparison(device.context, options, progress_));
    const std::string base = absl::StrCat(options.out, "/compare");
    nlohmann::ordered_json json = ToJson(comparisons);
    json["block_frames"] = options.bootstrap.block_frames;
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".csv", ToCsv(comparisons)));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".json", json.dump(2) + "\n"));
    int scored = 0, failed = 0;
    for (const ProfileComparison& comparison : comparisons) {
      scored += comparison.summary.drives;
      failed += comparison.summary.failed;
    }
    result_.Tell(name(), {{"drives", scored}, {"failed", failed}, {"scores", base + ".json"}},
                 Text(comparisons));
    if (scored > 0) {
      EGOSIEVE_RETURN_IF_ERROR(
          plots_.Write(absl::StrCat(options.out, "/plots"), MakeComparisonPage(comparisons)));
    }
    return failed > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  static std::string Text(const std::vector<ProfileComparison>& comparisons) {
    std::string text = absl::StrCat(ToTable(comparisons), "\n");
    for (const ProfileComparison& comparison : comparisons) {
      for (const std::string& line : CompareWithPaper(comparison.summary)) {
        absl::StrAppend(&text, comparison.profile, ": ", line, "\n");
      }
    }
    return text;
  }

  CompareFlags flags_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;
  PlotsFlag plots_;
};

}  // namespace

std::unique_ptr<Command> MakeCompareCommand() { return std::make_unique<CompareCommand>(); }

}  // namespace egosieve::tools
