#include "tools/evaluate/evaluate_flags.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/given_flags.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/switch_flag.h"
#include "tools/suite/suite_run.h"

namespace egosieve::tools {

void EvaluateFlags::AddFlags(CLI::App& app) {
  app.add_option("DIR", run_.folder, "The run folder; its eval.json and eval.csv are written")
      ->type_name("")
      ->configurable(false);
  app.add_option("--truth", run_.truth,
                 "Folder of masks (0 static, 128 void, else dynamic), a drive that synthesize "
                 "wrote, or a file of labelled points (track,label,frame,x,y; label 1 static)")
      ->type_name("TRUTH");
  AddFurtherTruthFlags(app);
  AddScoringFlags(app);
  const size_t others = app.get_options().size();
  AddSuiteFlags(app);
  of_suites_ = app.get_options();
  of_suites_.erase(of_suites_.begin(), of_suites_.begin() + static_cast<int64_t>(others));
}

void EvaluateFlags::AddFurtherTruthFlags(CLI::App& app) {
  app.add_option("--boxes", run_.given.boxes,
                 "Boxes of things that move or stand (frame,id,type,x1,y1,x2,y2,moving ...); "
                 "default: boxes.csv beside the frames")
      ->type_name("FILE");
  app.add_option("--poses", run_.given.poses,
                 "The camera's true poses, 12 numbers per frame; default: poses.txt beside the "
                 "frames. The run's trajectory.txt is compared with them")
      ->type_name("FILE");
  app.add_option("--poses_fps", run_.further.trajectory.frames_per_second,
                 "Rows of the poses per second, where no camera.json gives it")
      ->capture_default_str();
  app.add_option("--potential_from", run_.further.potential.from_seconds,
                 "Seconds of the drive from which the potential (segment --potential) is scored "
                 "against boxes or a synthetic drive's objects: it has to have seen things move")
      ->check(AtLeast(0.0))
      ->capture_default_str();
  app.add_option("--true_camera", run_.given.camera,
                 "The true lens, as in a run's camera.json; default: camera.json beside the "
                 "frames; with --suite: for sequences that have poses, but no camera.json")
      ->type_name("FILE");
}

void EvaluateFlags::AddScoringFlags(CLI::App& app) {
  AddWords(app, "--pixels", run_.maps.pixels,
           {{"grid", ScoredPixels::kGrid}, {"full", ScoredPixels::kFull}},
           "Which pixels are scored; grid: those of the maps; full: every one, after reconstruct");
  AddWords(app, "--match", run_.maps.match,
           {{"auto", MatchMasks::kAuto},
            {"name", MatchMasks::kName},
            {"number", MatchMasks::kNumber},
            {"order", MatchMasks::kOrder}},
           "How truth finds its frames: by name (the frame's, in a folder), by number (the "
           "frame's index), by order; auto: the first of these that fits");
  app.add_flag("--with_prior", run_.maps.with_prior,
               "Score the frames before the first that was learnt from, too");
  app.add_option("--threshold", run_.maps.scores.threshold,
                 "Probability from which a pixel is called moving, for IoU and F")
      ->capture_default_str();
  AddObjectFlags(app, run_.maps.scores.objects.thresholds);
  app.add_option("--object_iou", run_.maps.scores.objects.iou_threshold,
                 "IoU from which an object counts as found")
      ->capture_default_str();
  app.add_option("--object_area", run_.maps.scores.objects.min_area,
                 "Pixels of the image below which an object is not counted")
      ->capture_default_str();
}

void EvaluateFlags::AddSuiteFlags(CLI::App& app) {
  app.add_option("--suite", suite_.folder,
                 "Folder of sequences, each with frames/ and masks/, labels/, tracks.csv or a "
                 "scene.json: segments and scores them all")
      ->type_name("DIR");
  app.add_option("--out", suite_.suite.out,
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
  app.add_option("--jobs", suite_.suite.jobs,
                 "With --suite: sequences at a time; 0: one per core, at most one per sequence")
      ->check(Between(0, 256))
      ->capture_default_str();
  app.add_option("--max_seconds", suite_.suite.max_seconds,
                 "With --suite: seconds of each sequence at most, at the rate that camera.json "
                 "beside its frames states, else 10 frames per second; 0: all")
      ->check(AtLeast(0.0))
      ->capture_default_str();
  AddSwitch(app, "--masks", "--no_masks", suite_.suite.masks,
            "With --suite: make masks of each run by reconstruct, and score them");
  app.add_option("--max_frames", suite_.suite.max_frames,
                 "With --suite: frames of each sequence at most; 0: all")
      ->check(AtLeast<int64_t>(0))
      ->capture_default_str();
}

FurtherOptions EvaluateFlags::Further() const {
  FurtherOptions further = run_.further;
  further.pixels = run_.maps.pixels;
  further.with_prior = run_.maps.with_prior;
  further.boxes.threshold = run_.maps.scores.threshold;
  return further;
}

absl::StatusOr<std::variant<RunReportOptions, SuiteReportOptions>> EvaluateFlags::MakeOptions()
    const {
  if (suite_.folder.empty() == run_.folder.empty()) {
    return absl::InvalidArgumentError(
        "give either a run folder with --truth, or --suite with --out");
  }
  if (!suite_.folder.empty()) return OfSuite();
  if (const std::string flags = GivenFlags(of_suites_); !flags.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("no effect without --suite: ", flags, "; leave them out"));
  }
  RunReportOptions run = run_;
  run.further = Further();
  return run;
}

absl::StatusOr<SuiteReportOptions> EvaluateFlags::OfSuite() const {
  SuiteReportOptions options = suite_;
  SuiteOptions& suite = options.suite;
  if (suite.out.empty()) {
    return absl::InvalidArgumentError("--out is missing; give the folder for the suite's runs");
  }
  if (!run_.truth.empty() || !run_.given.boxes.empty() || !run_.given.poses.empty()) {
    return absl::InvalidArgumentError(
        "--truth, --boxes and --poses are those of one run; sequences have theirs beside their "
        "frames");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(suite.variants, ParseVariants(profiles_, variants_));
  suite.segment_flags = absl::StrSplit(segment_flags_, ' ', absl::SkipEmpty());
  suite.evaluate = run_.maps;
  suite.further = Further();
  suite.true_camera = run_.given.camera;
  return options;
}

}  // namespace egosieve::tools
