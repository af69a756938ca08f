// All figures of one map's run against one truth, gathered frame by frame.
//
// Pooled figures are over all scored pixels together; mean figures over the frames that have them.
// Frames without movers have no AUC and no IoU of their own: what they have is a false-positive
// rate at the declared threshold, pooled over them. Objects are scored by objects.h; with synthetic
// truth, recall is also given by heading, class, size and distance. Truth that is scattered points
// rather than an image has neither outlines nor objects: figures on these are absent then. Every
// figure is absent where nothing supports it.
//
// Memory: a few histograms of 65,536 bins, for any number of frames, and some numbers per frame.
#ifndef EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_
#define EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/evaluation/objects.h"
#include "tools/evaluation/roc.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/uncertainty.h"

namespace egosieve::tools {

struct DriveScoresOptions {
  double threshold = 0.5;  // declared: probabilities from here on are called dynamic
  int calibration_bins = 15;
  int curve_points = 200;  // of the ROC and precision-recall curves
  ObjectOptions objects;   // iou_threshold: of "found"; 0.3 and 0.5 are given in any case

  absl::Status Validate() const;
};

// One frame at the pixels that are scored: grid or full.
struct ScoredFrame {
  int64_t index = 0;
  cv::Mat1w probability;   // 16-bit scores (roc.h)
  cv::Mat1w deviation;     // 16 bits, any scale; may be empty
  cv::Mat1b truth;         // 0 static, 128 void, else dynamic
  bool scattered = false;  // pixels are points without order: neighbours in memory mean nothing
  cv::Mat1i ids;           // movers told apart; empty: connected components of the truth
  // What is known of the objects, by id; null: nothing.
  const std::map<int, SyntheticObject>* objects = nullptr;
};

// Thresholds 0.05, 0.10, ..., 0.95, at which the mean IoU over frames is given as well.
inline constexpr int kThresholdSteps = 19;
constexpr double ThresholdStep(int step) { return 0.05 * (step + 1); }

struct FrameScores {
  int64_t index = 0;
  int64_t dynamic_pixels = 0;  // of the truth
  int64_t static_pixels = 0;
  int64_t void_pixels = 0;
  bool has_movers = false;
  std::optional<double> auc;
  std::optional<double> average_precision;
  // At the declared threshold; absent without movers.
  std::optional<double> iou;
  std::optional<double> f;
  std::optional<double> boundary_f;
  std::optional<double> false_positive_rate;  // likewise; absent without static pixels
  std::optional<double> best_iou;             // at this frame's own best threshold
  std::optional<double> brier;
  std::optional<double> log_loss;
  std::array<double, kThresholdSteps> iou_at = {};  // where there are movers
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
  const UncertaintyHistogram& uncertainty() const { return uncertainty_; }
  bool has_deviation() const { return has_deviation_; }
  // The same for what the probability itself says of its doubt, sqrt(p (1 - p)): the deviation of
  // the class, where the map's is that of f.
  const UncertaintyHistogram& class_uncertainty() const { return class_uncertainty_; }
  // The mean over the frames that have the figure; absent where none has.
  std::optional<double> Mean(std::optional<double> FrameScores::*figure) const;
  // Over the frames with movers, at each ThresholdStep; empty where there is no such frame.
  std::vector<double> MeanIouByThreshold() const;
  // By group: "all", "relation ahead", "class car", "size 100-399", "distance under 20 m",
  // "ahead within 40 m", "ahead vehicle within 40 m" (neither pedestrian nor cyclist), ...
  const std::map<std::string, ObjectRecall>& recall() const { return recall_; }
  int64_t false_objects() const { return false_objects_; }
  int64_t frames_with_objects() const { return frames_with_objects_; }  // looked for in them
  // Absent where objects were looked for in no frame.
  std::optional<double> FalseObjectsPerFrame() const;
  // Pooled over the frames without movers; absent where there is none.
  std::optional<double> FalsePositiveRateWithoutMovers() const;

  // All of it, curves included; absent figures are null.
  nlohmann::ordered_json ToJson() const;
  // The figures that people read first, a line each.
  std::string Summary() const;

 private:
  struct Regions {
    ObjectScores objects;
    double boundary_f = 0.0;
  };

  absl::StatusOr<Regions> ScoreRegions(const ScoredFrame& frame) const;
  // From the frame's own histogram; counts what it adds to the frames without movers.
  void FillFrameScores(const RocHistogram& own, std::optional<double> boundary_f,
                       FrameScores& scores);
  void AppendThreshold(const char* name, int threshold, std::string* text) const;
  void AddObjects(const ScoredFrame& frame, const ObjectScores& scores);

  DriveScoresOptions options_;
  RocHistogram pooled_;
  UncertaintyHistogram uncertainty_;
  UncertaintyHistogram class_uncertainty_;
  bool has_deviation_ = false;
  std::vector<FrameScores> frames_;
  std::map<std::string, ObjectRecall> recall_;
  int64_t false_objects_ = 0;
  int64_t frames_with_objects_ = 0;
  int64_t mover_free_pixels_ = 0;
  int64_t mover_free_alarms_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_
