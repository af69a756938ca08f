#include "tools/evaluate/evaluate_command.h"

#include <string>
#include <variant>

#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/evaluate/evaluate_flags.h"
#include "tools/evaluate/evaluation_report.h"
#include "tools/plots/plots_flag.h"

namespace egosieve::tools {
namespace {

class EvaluateCommand : public Command {
 public:
  std::string name() const override { return "evaluate"; }
  std::string summary() const override {
    return "Scores a run's maps, or many sequences', against truth: ranking, thresholds, "
           "calibration, uncertainty, objects.";
  }
  std::string example() const override {
    return "egosieve evaluate out/drive --truth=drive/masks\n"
           "egosieve evaluate out/clip --truth=clip/tracks.csv\n"
           "egosieve evaluate out/clip --boxes=boxes.csv\n"
           "egosieve evaluate --suite=sequences --out=out/suite --jobs=2\n"
           "egosieve evaluate --suite=streets --out=out/terms --profiles=default "
           "--variant=line=--evidence=epipolar";
  }

  void AddFlags(CLI::App& app) override {
    flags_.AddFlags(app);
    plots_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const auto options, flags_.MakeOptions());
    const auto make = [&](const auto& of_one) { return MakeReport(of_one, progress_); };
    EGOSIEVE_ASSIGN_OR_RETURN(const EvaluationReport report, std::visit(make, options));
    result_.Tell(name(), report.fields, report.text);
    if (report.page) EGOSIEVE_RETURN_IF_ERROR(plots_.Write(report.plots, *report.page));
    return report.failed > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  EvaluateFlags flags_;
  ProgressFlag progress_;
  PlotsFlag plots_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeEvaluateCommand() { return std::make_unique<EvaluateCommand>(); }

}  // namespace egosieve::tools
