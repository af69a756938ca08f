#include "tools/evaluate/evaluate_command.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/evaluate/evaluate_run.h"
#include "tools/evaluate/evaluation_page.h"
#include "tools/evaluate/further_truth.h"
#include "tools/evaluate_features/feature_flags.h"
#include "tools/plots/plots_flag.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/suite/child_process.h"
#include "tools/suite/further_table.h"
#include "tools/suite/object_table.h"
#include "tools/suite/suite_figures.h"
#include "tools/suite/suite_run.h"
#include "tools/suite/suite_table.h"

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
    app.add_option("DIR", directory_, "The run folder; its eval.json and eval.csv are written")
        ->type_name("")
        ->configurable(false);
    app.add_option("--truth", truth_,
                   "Folder of masks (0 static, 128 void, else dynamic), a drive that synthesize "
                   "wrote, or a file of labelled points (track,label,frame,x,y; label 1 static)")
        ->type_name("TRUTH");
    AddFurtherTruthFlags(app);
    AddScoringFlags(app);
    AddSuiteFlags(app);
    plots_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
    features_.AddFlags(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    if (features_.wanted()) return features_.Run(directory_, truth_, suite_, progress_);
    if (suite_.empty() == directory_.empty()) {
      return absl::InvalidArgumentError(
          "give either a run folder with --truth, or --suite with --out");
    }
    return suite_.empty() ? EvaluateOne() : EvaluateSuite();
  }

 private:
  void AddFurtherTruthFlags(CLI::App& app) {
    app.add_option("--boxes", further_.boxes,
                   "Boxes of things that move or stand (frame,id,type,x1,y1,x2,y2,moving ...); "
                   "default: boxes.csv beside the frames")
        ->type_name("FILE");
    app.add_option("--poses", further_.poses,
                   "The camera's true poses, 12 numbers per frame; default: poses.txt beside the "
                   "frames. The run's trajectory.txt is compared with them")
        ->type_name("FILE");
    app.add_option("--poses_fps", trajectory_.frames_per_second,
                   "Rows of the poses per second, where no camera.json gives it")
        ->capture_default_str();
    app.add_option("--potential_from", potential_.from_seconds,
                   "Seconds of the drive from which the potential (segment --potential) is scored "
                   "against boxes or a synthetic drive's objects: it has to have seen things move")
        ->check(AtLeast(0.0))
        ->capture_default_str();
    app.add_option("--true_camera", further_.camera,
                   "The true lens, as in a run's camera.json; default: camera.json beside the "
                   "frames; with --suite: for sequences that have poses, but no camera.json")
        ->type_name("FILE");
  }

  // The given paths, else the files beside the input.
  FurtherTruth FurtherTruthOf(const std::string& input) const {
    FurtherTruth truth = FindFurtherTruth(input);
    if (!further_.boxes.empty()) truth.boxes = further_.boxes;
    if (!further_.poses.empty()) truth.poses = further_.poses;
    if (!further_.camera.empty()) truth.camera = further_.camera;
    return truth;
  }

  void AddScoringFlags(CLI::App& app) {
    AddWords(
        app, "--pixels", options_.pixels,
        {{"grid", ScoredPixels::kGrid}, {"full", ScoredPixels::kFull}},
        "Which pixels are scored; grid: those of the maps; full: every one, after reconstruct");
    AddWords(app, "--match", options_.match,
             {{"auto", MatchMasks::kAuto},
              {"name", MatchMasks::kName},
              {"number", MatchMasks::kNumber},
              {"order", MatchMasks::kOrder}},
             "How truth finds its frames: by name (the frame's, in a folder), by number (the "
             "frame's index), by order; auto: the first of these that fits");
    app.add_flag("--with_prior", options_.with_prior,
                 "Score the frames before the first that was learnt from, too");
    app.add_option("--threshold", options_.scores.threshold,
                   "Probability from which a pixel is called moving, for IoU and F")
        ->capture_default_str();
    AddObjectFlags(app, options_.scores.objects.thresholds);
    app.add_option("--object_iou", options_.scores.objects.iou_threshold,
                   "IoU from which an object counts as found")
        ->capture_default_str();
    app.add_option("--object_area", options_.scores.objects.min_area,
                   "Pixels of the image below which an object is not counted")
        ->capture_default_str();
  }

  void AddSuiteFlags(CLI::App& app) {
    app.add_option("--suite", suite_,
                   "Folder of sequences, each with frames/ and masks/, labels/, tracks.csv or a "
                   "scene.json: segments and scores them all")
        ->type_name("DIR");
    app.add_option("--out", suite_options_.out,
                   "With --suite: the folder for its runs, suite.json, .csv and .md; existing runs "
                   "are used or continued")
        ->type_name("DIR");
    app.add_option("--profiles", profiles_, "With --suite: profiles of segment, by commas")
        ->capture_default_str()
        ->type_name("NAMES");
    app.add_option("--variant", variants_,
                   "With --suite: one more way to segment, beside the profiles: a name and flags "
                   "of segment, by spaces; may be repeated")
        ->type_name("NAME=FLAGS");
    app.add_option("--segment_flags", segment_flags_,
                   "With --suite: further flags of segment, by spaces, the same for all sequences")
        ->type_name("FLAGS");
    app.add_option("--jobs", suite_options_.jobs,
                   "With --suite: sequences at a time; 0: one per core, at most one per sequence")
        ->check(Between(0, 256))
        ->capture_default_str();
    app.add_option("--max_seconds", suite_options_.max_seconds,
                   "With --suite: seconds of each sequence at most, at the rate that camera.json "
                   "beside its frames states, else 10 frames per second; 0: all")
        ->check(AtLeast(0.0))
        ->capture_default_str();
    app.add_flag("--masks,!--no_masks", suite_options_.masks,
                 "With --suite: make masks of each run by reconstruct, and score them");
    app.add_option("--max_frames", suite_options_.max_frames,
                   "With --suite: frames of each sequence at most; 0: all")
        ->check(AtLeast<int64_t>(0))
        ->capture_default_str();
  }

  absl::StatusOr<ExitCode> EvaluateOne() {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(
        const FurtherScores further,
        ScoreFurther(folder, FurtherTruthOf(description.input.path), FurtherOptionsOf()));
    if (truth_.empty() && further.empty()) {
      return absl::InvalidArgumentError(
          "--truth is missing, and no other truth lies beside the frames; give masks, tracks or "
          "--boxes to score against");
    }
    if (!further.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(
          WriteFileAtomically(folder.File("further.json"), ToJson(further).dump(2) + "\n"));
    }
    nlohmann::ordered_json fields = {{"run", folder.path()}, {"further", nullptr}};
    if (!further.empty()) fields["further"] = ToJson(further);
    std::string text = further.empty() ? "" : ToTable(further);
    if (!truth_.empty()) EGOSIEVE_RETURN_IF_ERROR(EvaluateMaps(folder, fields, text));
    result_.Tell(name(), fields, text);
    return ExitCode::kDone;
  }

  absl::Status EvaluateMaps(const RunFolder& folder, nlohmann::ordered_json& fields,
                            std::string& text) {
    Progress progress("evaluate", progress_, -1);
    EGOSIEVE_ASSIGN_OR_RETURN(const RunEvaluation run, EvaluateRun(folder, truth_, options_, [&] {
                                progress.Advance();
                                return !InterruptionRequested();
                              }));
    const Evaluation& evaluation = run.evaluation;
    progress.Finish();
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.csv"), ToCsv(evaluation)));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.json"), ToText(evaluation)));
    const auto or_null = [](const std::optional<double>& value) {
      return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
    };
    fields["truth"] = evaluation.truth;
    fields["pooled_auc"] = or_null(evaluation.pooled_auc);
    fields["mean_auc"] = or_null(evaluation.mean_auc);
    fields["frames_scored"] = evaluation.frames.size();
    fields["scores"] = folder.File("eval.json");
    absl::StrAppend(&text, ToTable(evaluation));
    return plots_.Write(folder.File("plots"), MakeEvaluationPage(run));
  }

  FurtherOptions FurtherOptionsOf() const {
    FurtherOptions further;
    further.pixels = options_.pixels;
    further.with_prior = options_.with_prior;
    further.boxes.threshold = options_.scores.threshold;
    further.potential = potential_;
    further.trajectory = trajectory_;
    return further;
  }

  absl::StatusOr<ExitCode> EvaluateSuite() {
    if (suite_options_.out.empty()) {
      return absl::InvalidArgumentError("--out is missing; give the folder for the suite's runs");
    }
    if (!further_.boxes.empty() || !further_.poses.empty()) {
      return absl::InvalidArgumentError(
          "--boxes and --poses are those of one run; sequences have theirs beside their frames");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, FindSequences(suite_));
    EGOSIEVE_ASSIGN_OR_RETURN(suite_options_.program, OwnProgram());
    suite_options_.variants.clear();
    for (const absl::string_view profile : absl::StrSplit(profiles_, ',', absl::SkipEmpty())) {
      suite_options_.variants.push_back(VariantOfProfile(std::string(profile)));
    }
    for (const std::string& text : variants_) {
      EGOSIEVE_ASSIGN_OR_RETURN(SuiteVariant variant, ParseVariant(text));
      suite_options_.variants.push_back(std::move(variant));
    }
    suite_options_.segment_flags = absl::StrSplit(segment_flags_, ' ', absl::SkipEmpty());
    suite_options_.evaluate = options_;
    suite_options_.further = FurtherOptionsOf();
    suite_options_.true_camera = further_.camera;
    suite_options_.cores = kernels::MaximumThreads();
    const int runs = static_cast<int>(list.sequences.size() * suite_options_.variants.size());
    if (suite_options_.jobs == 0) {
      suite_options_.jobs = std::clamp(suite_options_.cores, 1, std::clamp(runs, 1, 256));
    }
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(suite_options_.out));
    Progress progress("evaluate", progress_, runs, "sequence");
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<SequenceResult> results,
        RunSuite(list, suite_options_, InterruptionRequested, [&] { progress.Advance(); }));
    progress.Finish();
    const SuiteSummary summary = SummariseSuite(results);
    const std::string base = absl::StrCat(suite_options_.out, "/suite");
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".csv", ToCsv(results)));
    EGOSIEVE_RETURN_IF_ERROR(
        WriteFileAtomically(base + ".json", ToJson(list, results, summary).dump(2) + "\n"));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".md", ToMarkdown(results)));
    result_.Tell(name(),
                 {{"sequences", list.sequences.size()},
                  {"failed", summary.failed},
                  {"scores", base + ".json"}},
                 absl::StrCat(ToTable(list, results, summary), ObjectTable(results),
                              FurtherTable(results), "\n", ToMarkdown(results)));
    EGOSIEVE_RETURN_IF_ERROR(plots_.Write(absl::StrCat(suite_options_.out, "/plots"),
                                          MakeSuitePage(list, results, summary)));
    return summary.failed > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

  std::string directory_;
  std::string truth_;
  FurtherTruth further_;  // only the given paths
  PotentialScoresOptions potential_;
  TrajectoryErrorOptions trajectory_;
  EvaluateOptions options_;
  std::string suite_;
  std::string profiles_ = "paper,default";
  std::vector<std::string> variants_;
  std::string segment_flags_;
  SuiteOptions suite_options_;
  ProgressFlag progress_;
  PlotsFlag plots_;
  ResultFlag result_;
  FeatureFlags features_;
};

}  // namespace

std::unique_ptr<Command> MakeEvaluateCommand() { return std::make_unique<EvaluateCommand>(); }

}  // namespace egosieve::tools
