// The flags of `egosieve evaluate`, and the options that they make.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_FLAGS_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/evaluate/evaluation_report.h"

namespace egosieve::tools {

class EvaluateFlags {
 public:
  void AddFlags(CLI::App& app);

  // For a run or for a suite, whichever is given. InvalidArgument if not exactly one is.
  absl::StatusOr<std::variant<RunReportOptions, SuiteReportOptions>> MakeOptions() const;

 private:
  void AddFurtherTruthFlags(CLI::App& app);
  void AddScoringFlags(CLI::App& app);
  void AddSuiteFlags(CLI::App& app);
  FurtherOptions Further() const;
  absl::StatusOr<SuiteReportOptions> OfSuite() const;

  std::vector<CLI::Option*> of_suites_;  // flags that have no effect on one run
  RunReportOptions run_;                 // its scoring is the suite's, too
  SuiteReportOptions suite_;             // only what is the suite's own
  std::string profiles_ = "paper,default";
  std::vector<std::string> variants_;
  std::string segment_flags_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_FLAGS_H_
