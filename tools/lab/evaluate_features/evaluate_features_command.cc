#include "tools/lab/evaluate_features/evaluate_features_command.h"

#include <string>
#include <vector>

#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/lab/evaluate_features/evaluate_features.h"
#include "tools/lab/evaluate_features/feature_report.h"
#include "tools/lab/evaluate_features/feature_sequence.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/segment/segment_words.h"

namespace egosieve::tools {
namespace {

class EvaluateFeaturesCommand : public Command {
 public:
  std::string name() const override { return "evaluate_features"; }
  std::string summary() const override {
    return "Scores features' distances and labels, before anything is learnt, beside OpenCV's.";
  }
  std::string example() const override {
    return "egosieve lab evaluate_features drive/frames --truth=drive/masks\n"
           "egosieve lab evaluate_features sequences --every=5 --features_json=features.json";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", input_,
                   "With --truth: a video, a folder or a glob of images; without: a folder of "
                   "sequences, each with frames/ and its truth")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--truth", truth_,
                   "Folder of masks, or a file of labelled points, as for evaluate")
        ->type_name("TRUTH");
    app.add_option("--features_json", json_path_, "Where the scores of every frame are written")
        ->type_name("FILE")
        ->configurable(false);
    app.add_option("--every", options_.every, "Score every K-th frame; all are labelled")
        ->check(AtLeast(1))
        ->type_name("K")
        ->capture_default_str();
    app.add_option("--frame_gap", options_.labeller.frame_gap, "Frames between the two of a pair")
        ->check(Between(1, 100))
        ->type_name("FRAMES")
        ->capture_default_str();
    app.add_flag("--no_plain", without_plain_, "Leave plain OpenCV's figures out: much faster");
    AddWords(app, "--feature_source", options_.labeller.features, FeatureWords(),
             "Where labels come from");
    AddWords(app, "--flow_quality", options_.labeller.flow_quality, FlowQualityWords(),
             "Quality of the dense flow at the grid");
    AddWords(app, "--motion_model", options_.labeller.motion_model, MotionModelWords(),
             "Model of the static world's image motion");
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    options_.plain_ransac = !without_plain_;
    std::vector<FeatureSequence> sequences = {{input_, input_, truth_}};
    if (truth_.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(sequences, FindFeatureSequences(input_));
    }
    Progress progress("evaluate_features", progress_, -1);
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<SequenceScore> scores,
        EvaluateSequences(sequences, options_, [&] { return progress.AdvanceUninterrupted(); }));
    progress.Finish();
    nlohmann::ordered_json fields = {{"sequences", scores.size()}, {"scores", nullptr}};
    if (!json_path_.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(json_path_, ToJson(scores, options_)));
      fields["scores"] = json_path_;
    }
    result_.Tell(name(), fields, ToTable(scores));
    return ExitCode::kDone;
  }

 private:
  std::string input_, truth_, json_path_;
  bool without_plain_ = false;
  EvaluateFeaturesOptions options_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeEvaluateFeaturesCommand() {
  return std::make_unique<EvaluateFeaturesCommand>();
}

}  // namespace egosieve::tools
