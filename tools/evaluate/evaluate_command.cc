#include "tools/evaluate/evaluate_command.h"

#include <iostream>
#include <string>

#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/evaluate/evaluate_run.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

class EvaluateCommand : public Command {
 public:
  std::string name() const override { return "evaluate"; }
  std::string summary() const override {
    return "Scores a run's maps against truth: ranking, thresholds, calibration, objects.";
  }
  std::string example() const override {
    return "egosieve evaluate out/drive --truth=drive/masks\n"
           "egosieve evaluate out/clip --truth=clip/tracks.csv";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder; its eval.json and eval.csv are written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--truth", truth_,
                   "Folder of masks (0 static, 128 void, else dynamic), a drive that synthesize "
                   "wrote, or a file of labelled points (track,label,frame,x,y; label 1 static)")
        ->required()
        ->type_name("TRUTH");
    AddWords(
        app, "--pixels", options_.pixels,
        {{"grid", ScoredPixels::kGrid}, {"full", ScoredPixels::kFull}},
        "Which pixels are scored; grid: those of the maps; full: every one, after reconstruct");
    AddWords(app, "--match", options_.match,
             {{"auto", MatchMasks::kAuto},
              {"name", MatchMasks::kName},
              {"number", MatchMasks::kNumber},
              {"order", MatchMasks::kOrder}},
             "How masks find their frames: by name (the frame's, in a folder), by number (the "
             "frame's index), by order; auto: the first of these that fits");
    app.add_flag("--with_prior", options_.with_prior,
                 "Score the frames before the first that was learnt from, too");
    app.add_option("--threshold", options_.scores.threshold,
                   "Probability from which a pixel is called moving, for IoU, F and objects")
        ->capture_default_str();
    app.add_option("--object_iou", options_.scores.objects.iou_threshold,
                   "IoU from which an object counts as found")
        ->capture_default_str();
    app.add_option("--object_area", options_.scores.objects.min_area,
                   "Pixels of the image below which an object is not counted")
        ->capture_default_str();
    progress_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    CatchInterruptions();
    Progress progress("evaluate", progress_, -1);
    EGOSIEVE_ASSIGN_OR_RETURN(const RunEvaluation run, EvaluateRun(folder, truth_, options_, [&] {
                                progress.Advance();
                                return !InterruptionRequested();
                              }));
    const Evaluation& evaluation = run.evaluation;
    progress.Finish();
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.csv"), ToCsv(evaluation)));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.json"), ToText(evaluation)));
    std::cout << ToTable(evaluation);
    return ExitCode::kDone;
  }

 private:
  std::string directory_;
  std::string truth_;
  EvaluateOptions options_;
  ProgressFlag progress_;
};

}  // namespace

std::unique_ptr<Command> MakeEvaluateCommand() { return std::make_unique<EvaluateCommand>(); }

}  // namespace egosieve::tools
