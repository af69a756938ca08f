// Scores masks and numbers of reconstruct against truth: the measures of DAVIS, and the stability
// of numbers.
//
//   J   IoU of the mask in frames with movers, mean over frames
//   F   boundary measure (boundary.h), likewise
//   T   temporal instability (temporal_stability.h) between consecutive frames, mean over pairs,
//       and the same of the true masks
//   ids IDF1 and HOTA (identity.h), and the objects that were found (objects.h, with the movers of
//       ids as predicted objects), if the truth distinguishes its objects
//
// Frames are added in their order. Void pixels are static in both masks.
#ifndef EGOSIEVE_TOOLS_EVALUATION_MASK_SCORES_H_
#define EGOSIEVE_TOOLS_EVALUATION_MASK_SCORES_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/evaluation/identity.h"
#include "tools/evaluation/object_tally.h"
#include "tools/evaluation/objects.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/temporal_stability.h"

namespace egosieve::tools {

struct MaskFrame {
  int64_t index = 0;
  cv::Mat1b mask;   // not 0 where moving
  cv::Mat1b truth;  // 0 static, 128 void, else dynamic
  // Numbers of objects; empty if the truth, or the run, has none.
  cv::Mat1i ids, truth_ids;
  // Known properties of the true objects, by id; null: none.
  const std::map<int, SyntheticObject>* objects = nullptr;
};

class MaskScores {
 public:
  // objects: of the movers of ids; its thresholds are not read. Smaller ones do not count for
  // numbers, either.
  explicit MaskScores(const ObjectOptions& objects)
      : object_options_(objects), identity_(objects.min_area) {}

  // InvalidArgument, naming the sizes, if they differ; nothing is added then.
  absl::Status Add(const MaskFrame& frame);

  int64_t frames() const { return frames_; }
  std::optional<double> MeanJ() const { return j_.Value(); }
  std::optional<double> MeanF() const { return f_.Value(); }
  std::optional<double> MeanT() const { return t_.Value(); }
  std::optional<double> TruthT() const { return truth_t_.Value(); }
  std::optional<IdentityScores> Identity() const { return identity_.Score(); }
  const ObjectTally& objects() const { return objects_; }

  nlohmann::ordered_json ToJson() const;  // absent figures are null
  std::string Summary() const;            // for people, one or two lines; empty without frames

 private:
  struct Mean {
    double sum = 0.0;
    int64_t count = 0;
    void Add(double value) { sum += value, ++count; }
    std::optional<double> Value() const {
      return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
    }
  };

  int64_t frames_ = 0;
  int64_t last_index_ = -2;
  Mean j_, f_, t_, truth_t_;
  std::vector<ShapeContext> outline_, truth_outline_;
  ObjectOptions object_options_;
  ObjectTally objects_;
  IdentityScorer identity_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_MASK_SCORES_H_
