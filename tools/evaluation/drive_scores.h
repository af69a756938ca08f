// All figures of one map's run against one truth, gathered frame by frame.
//
// Pooled figures are over all scored pixels together; mean figures over the frames that have them.
// Frames without movers have no AUC and no IoU of their own: what they have is a false-positive
// rate at the declared threshold, pooled over them. Objects are scored by objects.h; with synthetic
// truth, recall is also told by heading, class, size and distance. Every figure is absent where
// nothing supports it.
//
// Memory: a few histograms of 65,536 bins, whatever the number of frames, and some numbers a frame.
#ifndef EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_
#define EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/evaluation/objects.h"
#include "tools/evaluation/roc.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/uncertainty.h"

namespace egosieve::tools {

struct DriveScoresOptions {
  double threshold = 0.5;  // declared: probabilities from here on are called dynamic
  int calibration_bins = 15;
  int curve_points = 200;  // of the ROC and precision-recall curves
  ObjectOptions objects;   // iou_threshold: of "found"; 0.3 and 0.5 are told in any case

  absl::Status Validate() const;
};

// One frame at the pixels that are scored: grid or full.
struct ScoredFrame {
  int64_t index = 0;
  cv::Mat1w probability;  // 16-bit scores (roc.h)
  cv::Mat1w deviation;    // 16 bits, any scale; may be empty
  cv::Mat1b truth;        // 0 static, 128 void, else dynamic
  cv::Mat1i ids;          // movers told apart; empty: connected components of the truth
  // What is known of the objects, by id; null: nothing.
  const std::map<int, SyntheticObject>* objects = nullptr;
};

struct FrameScores {
  int64_t index = 0;
  std::optional<double> auc;
  std::optional<double> iou;         // at the declared threshold
  std::optional<double> boundary_f;  // likewise
  double false_positive_rate = 0.0;  // likewise; of the static pixels
  bool has_movers = false;
};

// How many objects of a group were seen and found.
struct ObjectRecall {
  int64_t objects = 0;      // frame by frame: one that is seen in ten frames counts ten times
  int64_t found = 0;        // at the options' IoU
  int64_t found_at_30 = 0;  // IoU of 0.3 or more
  int64_t found_at_50 = 0;
  double iou_sum = 0.0;
};

class DriveScores {
 public:
  explicit DriveScores(const DriveScoresOptions& options);

  // InvalidArgument, naming the sizes, where a frame's maps differ in size; nothing is added then.
  absl::Status Add(const ScoredFrame& frame);
  // `other`: of the same options and later frames.
  void Merge(const DriveScores& other);

  const std::vector<FrameScores>& frames() const { return frames_; }
  const RocHistogram& pooled() const { return pooled_; }
  // By group: "all", "relation ahead", "class car", "size 100-399", "distance under 20 m",
  // "ahead within 40 m", ...
  const std::map<std::string, ObjectRecall>& recall() const { return recall_; }
  double FalseObjectsPerFrame() const;
  // Pooled over the frames without movers; absent where there is none.
  std::optional<double> FalsePositiveRateWithoutMovers() const;

  // All of it, curves included; absent figures are null.
  nlohmann::ordered_json ToJson() const;
  // The figures that people read first, a line each.
  std::string Summary() const;

 private:
  void AddObjects(const ScoredFrame& frame, const ObjectScores& scores);

  DriveScoresOptions options_;
  RocHistogram pooled_;
  UncertaintyHistogram uncertainty_;
  bool has_deviation_ = false;
  std::vector<FrameScores> frames_;
  std::map<std::string, ObjectRecall> recall_;
  int64_t false_objects_ = 0;
  int64_t mover_free_pixels_ = 0;
  int64_t mover_free_alarms_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_
