// Further truth in a drive's folder, beside masks and tracks, and how a run compares with it.
//
//   boxes.csv        things in boxes (box_truth.h): which of them are marked (box_scores.h)
//   poses.txt        the camera's poses (KITTI's format, row k is frame k), camera.json its lens
//                    and rate: against the run's trajectory.txt (TUM) and camera.json
//                    (trajectory_errors.h)
//   own_vehicle.png  255 on the own vehicle: its share that is marked
//   scene.json       a synthetic drive: with boxes.csv, the truth for a run's potential
//                    (potential_scores.h)
#ifndef EGOSIEVE_TOOLS_EVALUATE_FURTHER_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATE_FURTHER_TRUTH_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "tools/evaluate/potential_scores.h"
#include "tools/evaluate/scored_maps.h"
#include "tools/evaluation/box_scores.h"
#include "tools/evaluation/trajectory_errors.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// Paths; empty: not known.
struct FurtherTruth {
  std::string boxes;
  std::string poses;
  std::string camera;
  std::string own_vehicle;
  std::string scene;
};

// Finds these files beside the input: in the folder that holds frames/ or the video.
FurtherTruth FindFurtherTruth(const std::string& input);

struct FurtherOptions {
  ScoredPixels pixels = ScoredPixels::kGrid;
  bool with_prior = false;
  BoxScoresOptions boxes;
  PotentialScoresOptions potential;
  TrajectoryErrorOptions trajectory;  // its rate is used if camera.json gives none
};

struct FurtherScores {
  std::optional<BoxScores> boxes;  // if a frame with boxes has a map
  std::optional<TrajectoryErrors> trajectory;
  // The same if row k is frame k + row_shift, where row_shift is 1 or -1. Set only if that at least
  // halves the rotation error: the truth's clock is then in doubt.
  std::optional<TrajectoryErrors> shifted;
  int row_shift = 0;
  std::optional<double> focal_error_percent;
  std::optional<double> own_vehicle_marked;  // share of its pixels, mean over frames
  PotentialScores potential;

  bool empty() const;
};

// Scores are empty if the run or the truth lacks the data. DataLoss for damaged files; NotFound if
// a given path does not exist.
absl::StatusOr<FurtherScores> ScoreFurther(const RunFolder& folder, const FurtherTruth& truth,
                                           const FurtherOptions& options);

nlohmann::ordered_json ToJson(const FurtherScores& scores);
std::string ToTable(const FurtherScores& scores);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_FURTHER_TRUTH_H_
