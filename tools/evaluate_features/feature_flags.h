// `egosieve evaluate --features`: the flags, and the run.
#ifndef EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_FLAGS_H_
#define EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/progress.h"
#include "tools/evaluate_features/evaluate_features.h"

namespace egosieve::tools {

class FeatureFlags {
 public:
  // Adds --features, --every, --features_json and the labeller's flags.
  void AddFlags(CLI::App& app);

  bool wanted() const { return wanted_; }

  // Scores either `input` with `truth` (frames and masks or tracks; without a truth, a folder as in
  // feature_sequence.h), or `suite`, a folder of such folders. Prints the table and writes the
  // JSON.
  absl::StatusOr<ExitCode> Run(const std::string& input, const std::string& truth,
                               const std::string& suite, const ProgressFlag& progress) const;

 private:
  bool wanted_ = false;
  bool without_plain_ = false;
  std::string json_path_;
  EvaluateFeaturesOptions options_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_FLAGS_H_
