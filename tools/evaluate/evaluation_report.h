// The work of `egosieve evaluate`: scores one run or a suite, writes the scores' files, and returns
// what is told of them.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATION_REPORT_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATION_REPORT_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/progress.h"
#include "tools/evaluate/evaluate_run.h"
#include "tools/evaluate/further_truth.h"
#include "tools/plots/plot_page.h"
#include "tools/suite/suite_run.h"

namespace egosieve::tools {

struct RunReportOptions {
  std::string folder;  // the run's
  std::string truth;   // of drive_truth.h; may be empty
  FurtherTruth given;  // only the given paths; the others are found beside the input
  EvaluateOptions maps;
  FurtherOptions further;
};

struct SuiteReportOptions {
  std::string folder;  // of sequences
  SuiteOptions suite;  // without program and cores; jobs 0: one per core, at most one per run
};

struct EvaluationReport {
  nlohmann::ordered_json fields;  // of the result (result_flag.h)
  std::string text;
  std::optional<PlotPage> page;
  std::string plots;  // the page's folder
  int failed = 0;     // runs of a suite
};

// further.json where there is further truth, eval.json and eval.csv where there is a truth, in the
// run's folder. InvalidArgument if there is neither.
absl::StatusOr<EvaluationReport> MakeReport(const RunReportOptions& options,
                                            const ProgressFlag& progress);

// suite.json, suite.csv and suite.md in the suite's folder of output.
absl::StatusOr<EvaluationReport> MakeReport(const SuiteReportOptions& options,
                                            const ProgressFlag& progress);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATION_REPORT_H_
