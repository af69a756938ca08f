// How well a run's potential (vision/segmentation/potential_model.h) ranks standing things that
// could move above the scenery: the area under the ROC curve at the grid's pixels, by kind of
// thing.
//
// The truth is a synthetic drive, whose objects are known per pixel (synthetic_truth.h), or boxes
// (box_truth.h). With boxes, a thing is the middle of its box, and scenery is everything outside
// all boxes.
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
  double from_seconds = 0.0;  // time in the drive; earlier frames are left out
  double middle = 0.6;        // of each side of a box, in (0, 1]
};

class PotentialScores {
 public:
  // `kinds`: one per pixel of the grid, row by row; "": scenery; "void": left out.
  void Add(const cv::Mat1f& potential, const std::vector<std::string>& kinds);

  bool empty() const { return frames_ == 0; }
  // For "standing vehicle" and so on against scenery; absent if either has no pixels.
  std::optional<double> Auc(const std::string& kind) const;
  nlohmann::ordered_json ToJson() const;
  std::string ToTable() const;  // one line per kind

 private:
  std::map<std::string, RocHistogram> kinds_;  // positives
  RocHistogram scenery_;                       // negatives
  int64_t frames_ = 0;
};

// Kinds of the grid's pixels, from the boxes of one frame.
std::vector<std::string> KindsByBoxes(const std::vector<LabelledBox>& boxes,
                                      const kernels::ImageGrid& grid, double middle);

// Scores the run's potential maps; empty if it has none or no truth is known. scene: the folder of
// a synthetic drive; boxes: a file; either empty if not known.
absl::StatusOr<PotentialScores> ScorePotential(const RunFolder& folder, const std::string& scene,
                                               const std::string& boxes,
                                               const PotentialScoresOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_POTENTIAL_SCORES_H_
