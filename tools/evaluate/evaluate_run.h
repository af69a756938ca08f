// Scores a run's maps against a truth (drive_truth.h).
//
// Scored are the grid's pixels (the 16-bit probabilities as they were written, nothing
// interpolated), or, where the run was reconstructed and that is asked for, every pixel of full/.
// Truth at tracks takes the grid's maps, interpolated linearly at each point. Frames before the
// first that was learnt from carry the prior, the same everywhere: they are left out and counted,
// unless `with_prior` is set.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_

#include <functional>

#include "absl/status/statusor.h"
#include "tools/evaluate/drive_truth.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/scored_maps.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct EvaluateOptions {
  ScoredPixels pixels = ScoredPixels::kGrid;
  MatchMasks match = MatchMasks::kAuto;
  bool with_prior = false;
  // Its areas are in pixels of the image, whatever is scored.
  DriveScoresOptions scores = DefaultScores();

  // Objects below 100 pixels of the image are not counted.
  static DriveScoresOptions DefaultScores() {
    DriveScoresOptions options;
    options.objects.min_area = 100;
    return options;
  }
  // With areas in pixels of a grid of that stride.
  DriveScoresOptions ScoresAtStride(int stride) const;
};

struct RunEvaluation {
  Evaluation evaluation;
  DriveScores scores;  // the same as histograms, for merging over runs
};

// FailedPrecondition where no frame has both a map and a truth, where masks have another size than
// their frames, or where the truth lies beside the frames of another drive: no figure is computed
// from nothing. `after_frame` is called after each frame; returning false cancels.
absl::StatusOr<RunEvaluation> EvaluateRun(const RunFolder& folder, const std::string& truth,
                                          const EvaluateOptions& options,
                                          const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
