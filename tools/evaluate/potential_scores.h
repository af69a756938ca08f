// How a run's potential (vision/segmentation/potential_model.h) ranks things that could move, and
// stand, above the scenery: the area under the ROC curve at the grid's pixels, by kind of thing.
//
// Truth is a synthetic drive, whose objects are known pixel by pixel (synthetic_truth.h), or boxes
// (box_truth.h): then a thing is the middle of its box, and scenery what lies in no box.
#ifndef EGOSIEVE_TOOLS_EVALUATE_POTENTIAL_SCORES_H_
#define EGOSIEVE_TOOLS_EVALUATE_POTENTIAL_SCORES_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "tools/evaluation/box_truth.h"
#include "tools/evaluation/roc.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct PotentialScoresOptions {
  double from_seconds = 0.0;  // of the drive; frames before are left out
  double middle = 0.6;        // of each side of a box, in (0, 1]
};

class PotentialScores {
 public:
  // `kinds`: of each of the grid's pixels, row by row; "": scenery; "void": left out.
  void Add(const cv::Mat1f& potential, const std::vector<std::string>& kinds);

  bool empty() const { return frames_ == 0; }
  // Of "standing vehicle" and so on against scenery; nothing without pixels of either.
  std::optional<double> Auc(const std::string& kind) const;
  nlohmann::ordered_json ToJson() const;
  std::string ToTable() const;  // a line a kind

 private:
  std::map<std::string, RocHistogram> kinds_;  // positives
  RocHistogram scenery_;                       // negatives
  int64_t frames_ = 0;
};

// Kinds of the grid's pixels by boxes of one frame.
std::vector<std::string> KindsByBoxes(const std::vector<LabelledBox>& boxes,
                                      const kernels::ImageGrid& grid, double middle);

// Of the run's potential maps; empty where it has none, or no truth is known. scene: the folder of
// a synthetic drive; boxes: a file; empty: not known.
absl::StatusOr<PotentialScores> ScorePotential(const RunFolder& folder, const std::string& scene,
                                               const std::string& boxes,
                                               const PotentialScoresOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_POTENTIAL_SCORES_H_
