#include "tools/evaluate_features/feature_flags.h"

#include <iostream>
#include <utility>

#include "absl/status/status.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/evaluate_features/feature_report.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/segment/segment_words.h"

namespace egosieve::tools {
namespace {

constexpr char kGroup[] = "With --features";

absl::StatusOr<std::vector<FeatureSequence>> Sequences(const std::string& input,
                                                       const std::string& truth,
                                                       const std::string& suite) {
  if (!suite.empty()) {
    if (!input.empty()) {
      return absl::InvalidArgumentError("give an input or --suite, not both");
    }
    return FindFeatureSequences(suite);
  }
  if (input.empty()) {
    return absl::InvalidArgumentError(
        "nothing to evaluate: give frames with --truth, or a folder of sequences with --suite");
  }
  if (truth.empty()) return FindFeatureSequences(input);
  return std::vector<FeatureSequence>{{input, input, truth}};
}

}  // namespace

void FeatureFlags::AddFlags(CLI::App& app) {
  app.add_flag("--features", wanted_,
               "Score the features' distances and labels, before anything is learnt from them, "
               "beside plain OpenCV's; the input is frames")
      ->group(kGroup);
  app.add_option("--features_json", json_path_, "Where the scores of every frame are written")
      ->type_name("FILE")
      ->configurable(false)
      ->group(kGroup);
  app.add_option("--every", options_.every, "Score every K-th frame; all are labelled")
      ->check(AtLeast(1))
      ->type_name("K")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--frame_gap", options_.labeller.frame_gap, "Frames between the two of a pair")
      ->check(Between(1, 100))
      ->type_name("FRAMES")
      ->capture_default_str()
      ->group(kGroup);
  app.add_flag("--no_plain", without_plain_, "Leave plain OpenCV's figures out: much faster")
      ->group(kGroup);
  AddWords(app, "--feature_source", options_.labeller.features, FeatureWords(),
           "Where labels come from")
      ->group(kGroup);
  AddWords(app, "--flow_quality", options_.labeller.flow_quality, FlowQualityWords(),
           "Quality of the dense flow at the grid")
      ->group(kGroup);
  AddWords(app, "--motion_model", options_.labeller.motion_model, MotionModelWords(),
           "Model of the static world's image motion")
      ->group(kGroup);
}

absl::StatusOr<ExitCode> FeatureFlags::Run(const std::string& input, const std::string& truth,
                                           const std::string& suite,
                                           const ProgressFlag& progress_flag) const {
  EvaluateFeaturesOptions options = options_;
  options.plain_ransac = !without_plain_;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FeatureSequence> sequences,
                            Sequences(input, truth, suite));
  Progress progress("evaluate", progress_flag, -1);
  std::vector<SequenceScore> scores;
  for (const FeatureSequence& sequence : sequences) {
    EGOSIEVE_ASSIGN_OR_RETURN(SequenceScore score, EvaluateSequence(sequence, options, [&] {
                                progress.Advance();
                                return !InterruptionRequested();
                              }));
    scores.push_back(std::move(score));
  }
  progress.Finish();
  if (!json_path_.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(json_path_, ToJson(scores, options)));
  }
  std::cout << ToTable(scores);
  return ExitCode::kDone;
}

}  // namespace egosieve::tools
