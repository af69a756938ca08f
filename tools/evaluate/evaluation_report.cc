#include "tools/evaluate/evaluation_report.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/evaluate/evaluation_page.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/run_folder.h"
#include "tools/suite/child_process.h"
#include "tools/suite/further_table.h"
#include "tools/suite/object_table.h"
#include "tools/suite/sequences.h"
#include "tools/suite/suite_figures.h"
#include "tools/suite/suite_table.h"

namespace egosieve::tools {
namespace {

// The given paths, else the files beside the input.
FurtherTruth FurtherTruthOf(const std::string& input, const FurtherTruth& given) {
  FurtherTruth truth = FindFurtherTruth(input);
  if (!given.boxes.empty()) truth.boxes = given.boxes;
  if (!given.poses.empty()) truth.poses = given.poses;
  if (!given.camera.empty()) truth.camera = given.camera;
  return truth;
}

nlohmann::ordered_json OrNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

// Adds the scores of the maps.
absl::Status AddMaps(const RunFolder& folder, const RunReportOptions& options,
                     const ProgressFlag& flag, EvaluationReport& report) {
  Progress progress("evaluate", flag, -1);
  EGOSIEVE_ASSIGN_OR_RETURN(const RunEvaluation run,
                            EvaluateRun(folder, options.truth, options.maps,
                                        [&] { return progress.AdvanceUninterrupted(); }));
  const Evaluation& evaluation = run.evaluation;
  progress.Finish();
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.csv"), ToCsv(evaluation)));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.json"), ToText(evaluation)));
  report.fields["truth"] = evaluation.truth;
  report.fields["pooled_auc"] = OrNull(evaluation.pooled_auc);
  report.fields["mean_auc"] = OrNull(evaluation.mean_auc);
  report.fields["frames_scored"] = evaluation.frames.size();
  report.fields["scores"] = folder.File("eval.json");
  absl::StrAppend(&report.text, ToTable(evaluation));
  report.page = MakeEvaluationPage(run);
  report.plots = folder.File("plots");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<EvaluationReport> MakeReport(const RunReportOptions& options,
                                            const ProgressFlag& progress) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(options.folder));
  EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(
      const FurtherScores further,
      ScoreFurther(folder, FurtherTruthOf(description.input.path, options.given), options.further));
  if (options.truth.empty() && further.empty()) {
    return absl::InvalidArgumentError(
        "--truth is missing, and no other truth lies beside the frames; give masks, tracks or "
        "--boxes to score against");
  }
  EvaluationReport report;
  report.fields = {{"run", folder.path()}, {"further", nullptr}};
  if (!further.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(
        WriteFileAtomically(folder.File("further.json"), ToJson(further).dump(2) + "\n"));
    report.fields["further"] = ToJson(further);
    report.text = ToTable(further);
  }
  if (!options.truth.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(AddMaps(folder, options, progress, report));
  }
  return report;
}

absl::StatusOr<EvaluationReport> MakeReport(const SuiteReportOptions& options,
                                            const ProgressFlag& flag) {
  EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, FindSequences(options.folder));
  SuiteOptions suite = options.suite;
  EGOSIEVE_ASSIGN_OR_RETURN(suite.program, OwnProgram());
  suite.cores = kernels::MaximumThreads();
  const int runs = static_cast<int>(list.sequences.size() * suite.variants.size());
  if (suite.jobs == 0) suite.jobs = std::clamp(suite.cores, 1, std::clamp(runs, 1, 256));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(suite.out));
  Progress progress("evaluate", flag, runs, "sequence");
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::vector<SequenceResult> results,
      RunSuite(list, suite, InterruptionRequested, [&] { progress.Advance(); }));
  progress.Finish();
  const SuiteSummary summary = SummariseSuite(results);
  const std::string base = absl::StrCat(suite.out, "/suite");
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".csv", ToCsv(results)));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(base + ".json", ToJson(list, results, summary).dump(2) + "\n"));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".md", ToMarkdown(results)));
  return EvaluationReport{{{"sequences", list.sequences.size()},
                           {"failed", summary.failed},
                           {"scores", base + ".json"}},
                          absl::StrCat(ToTable(list, results, summary), ObjectTable(results),
                                       FurtherTable(results), "\n", ToMarkdown(results)),
                          MakeSuitePage(list, results, summary),
                          absl::StrCat(suite.out, "/plots"),
                          summary.failed};
}

}  // namespace egosieve::tools
