// How `egosieve lab compare` scores maps: as egosieve-eval does.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_

#include <algorithm>

#include "tools/evaluation/drive_scores.h"
#include "tools/masks/truth_masks.h"

namespace egosieve::tools {

struct EvaluateOptions {
  MatchMasks match = MatchMasks::kAuto;
  // Its areas are in pixels of the image.
  DriveScoresOptions scores = DefaultScores();

  // Objects below 100 pixels of the image are not counted.
  static DriveScoresOptions DefaultScores() {
    DriveScoresOptions options;
    options.objects.min_area = 100;
    return options;
  }
  // The same with areas in pixels of a grid of this stride.
  DriveScoresOptions ScoresAtStride(int stride) const {
    DriveScoresOptions at_grid = scores;
    at_grid.objects.min_area = std::max(1, scores.objects.min_area / (stride * stride));
    return at_grid;
  }
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_RUN_H_
