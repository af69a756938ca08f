// All figures of one run's maps against one truth, collected frame by frame.
//
// Pooled figures are over all scored pixels together; mean figures are over the frames that have
// them. Frames without movers have no AUC and no IoU; they give a false-positive rate at the
// declared threshold, pooled over these frames. Objects are scored by objects.h; with synthetic
// truth, recall is also given by heading, class, size and distance. If the truth is scattered
// points instead of an image, figures of outlines and objects are absent. A figure is absent
// whenever there are no data for it.
//
// Memory: a few histograms of 65,536 bins for all frames, and some numbers per frame.
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
#include "tools/evaluation/object_tally.h"
#include "tools/evaluation/objects.h"
#include "tools/evaluation/roc.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/uncertainty.h"

namespace egosieve::tools {

struct DriveScoresOptions {
  double threshold = 0.5;  // declared: probabilities of this value or more are called dynamic
  int calibration_bins = 15;
  int curve_points = 200;  // of the ROC and precision-recall curves
  ObjectOptions objects;   // iou_threshold: of "found"; 0.3 and 0.5 are always given

  absl::Status Validate() const;
};

// One frame at the scored pixels: grid or full.
struct ScoredFrame {
  int64_t index = 0;
  cv::Mat1w probability;   // 16-bit scores (roc.h)
  cv::Mat1w deviation;     // 16 bits, any scale; may be empty
  cv::Mat1b truth;         // 0 static, 128 void, else dynamic
  bool scattered = false;  // pixels are unordered points: neighbours in memory are not neighbours
  cv::Mat1i ids;           // numbers of movers; empty: connected components of the truth
  // Known properties of the objects, by id; null: none.
  const std::map<int, SyntheticObject>* objects = nullptr;
};

// Thresholds 0.05, 0.10, ..., 0.95, at which the mean IoU over frames is also given.
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
  std::array<double, kThresholdSteps> iou_at = {};  // in frames with movers
};

class DriveScores {
 public:
  explicit DriveScores(const DriveScoresOptions& options);

  // InvalidArgument, naming the sizes, if a frame's maps differ in size; nothing is added then.
  absl::Status Add(const ScoredFrame& frame);
  // `other`: has the same options and later frames.
  void Merge(const DriveScores& other);

  const std::vector<FrameScores>& frames() const { return frames_; }
  const RocHistogram& pooled() const { return pooled_; }
  const UncertaintyHistogram& uncertainty() const { return uncertainty_; }
  bool has_deviation() const { return has_deviation_; }
  // The same for the deviation of the class, sqrt(p (1 - p)), which follows from the probability;
  // the map's deviation is that of f.
  const UncertaintyHistogram& class_uncertainty() const { return class_uncertainty_; }
  // The mean over the frames that have the figure; absent if none has it.
  std::optional<double> Mean(std::optional<double> FrameScores::*figure) const;
  // Over the frames with movers, at each ThresholdStep; empty if there are no such frames.
  std::vector<double> MeanIouByThreshold() const;
  const ObjectTally& objects() const { return objects_; }
  // Pooled over the frames without movers; absent if there are none.
  std::optional<double> FalsePositiveRateWithoutMovers() const;

  // All figures, including curves; absent figures are null.
  nlohmann::ordered_json ToJson() const;
  // The main figures for people, one per line.
  std::string Summary() const;

 private:
  struct Regions {
    ObjectScores objects;
    double boundary_f = 0.0;
  };

  absl::StatusOr<Regions> ScoreRegions(const ScoredFrame& frame) const;
  // Fills the scores from the frame's own histogram; adds to the counts of frames without movers.
  void FillFrameScores(const RocHistogram& own, std::optional<double> boundary_f,
                       FrameScores& scores);
  void AppendThreshold(const char* name, int threshold, std::string* text) const;

  DriveScoresOptions options_;
  RocHistogram pooled_;
  UncertaintyHistogram uncertainty_;
  UncertaintyHistogram class_uncertainty_;
  bool has_deviation_ = false;
  std::vector<FrameScores> frames_;
  ObjectTally objects_;
  int64_t mover_free_pixels_ = 0;
  int64_t mover_free_alarms_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_DRIVE_SCORES_H_
