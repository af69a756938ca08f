// Scores a run's maps against a truth (drive_truth.h).
//
// The scored pixels are those of the grid (the 16-bit probabilities as written, without
// interpolation) or, if requested and the run was reconstructed, all pixels of full/. For truth at
// tracks, the grid's maps are interpolated linearly at each point. Frames before the first learnt
// frame have the map of the prior, which is the same everywhere: they are left out and counted,
// unless `with_prior` is set. Masks of reconstruct are scored unchanged, at full resolution, in
// every frame with a mask.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_

#include <functional>

#include "absl/status/statusor.h"
#include "tools/evaluate/drive_truth.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/scored_maps.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/evaluation/mask_scores.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct EvaluateOptions {
  ScoredPixels pixels = ScoredPixels::kGrid;
  MatchMasks match = MatchMasks::kAuto;
  bool with_prior = false;
  // Its areas are in pixels of the image, for any scored pixels.
  DriveScoresOptions scores = DefaultScores();

  // Objects below 100 pixels of the image are not counted.
  static DriveScoresOptions DefaultScores() {
    DriveScoresOptions options;
    options.objects.min_area = 100;
    return options;
  }
  // The same with areas in pixels of a grid of this stride.
  DriveScoresOptions ScoresAtStride(int stride) const;
};

struct RunEvaluation {
  Evaluation evaluation;
  DriveScores scores;                 // the same as histograms, for merging runs
  MaskScores masks{ObjectOptions()};  // of masks/ and ids/, if reconstruct has written them
};

// FailedPrecondition if no frame has both a map and a truth, if masks differ in size from their
// frames, or if the truth belongs to the frames of another drive. `after_frame` is called after
// each frame; returning false cancels.
absl::StatusOr<RunEvaluation> EvaluateRun(const RunFolder& folder, const std::string& truth,
                                          const EvaluateOptions& options,
                                          const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
