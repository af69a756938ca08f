// Scores a run's maps against truth masks.
//
// Scored are the grid's pixels (the 16-bit probabilities as they were written, nothing
// interpolated), or, where the run was reconstructed and that is asked for, every pixel of full/.
// Frames before the first that was learnt from carry the prior, the same everywhere: they are left
// out and counted, unless `with_prior` is set.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_

#include <functional>

#include "absl/status/statusor.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/truth_masks.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

enum class ScoredPixels { kGrid, kFull };

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
};

// FailedPrecondition where no frame has both a map and a mask: no figure is computed from nothing.
// `after_frame` is called after each frame; returning false cancels.
absl::StatusOr<Evaluation> EvaluateRun(const RunFolder& folder, const std::string& truth,
                                       const EvaluateOptions& options,
                                       const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
