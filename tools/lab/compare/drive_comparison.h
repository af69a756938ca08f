// Compares several methods on the same features, frames and pixels of one drive with its truth.
// Features and labels are those of `segment`: with the camera of a first pass and the frames ahead.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_DRIVE_COMPARISON_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_DRIVE_COMPARISON_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "tools/evaluate/evaluate_run.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/suite/sequences.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

struct ComparisonOptions {
  std::vector<std::string> methods;
  vision::OnlineSegmenterOptions segmenter;
  EvaluateOptions evaluate;  // its `pixels` must be kGrid
  int64_t max_frames = 0;    // 0: all
};

// One method in one frame of the drive, scored or not.
struct MethodFrame {
  int64_t index = 0;
  std::optional<double> auc;                // absent if the frame was not scored or has one class
  std::optional<double> auc_without_prior;  // the same without the location prior
  int64_t model_size = 0;
  double own_milliseconds = 0.0;
  std::optional<double> iou = std::nullopt;  // at the threshold; absent without movers
};

struct MethodResult {
  std::string method;
  bool probabilistic = false;
  DriveScores scores;
  std::vector<MethodFrame> frames;
};

// Counts of labels of features, compared with the mask's pixel; dynamic means p >= 1/2.
struct LabelCounts {
  int64_t features[2] = {0, 0};  // on the static scene, on movers
  int64_t dynamic[2] = {0, 0};   // of these, with a dynamic label

  void Add(const LabelCounts& other);
  // The share of dynamic labels that lie on movers. Absent without dynamic labels.
  std::optional<double> Precision() const;
  // The share of features on movers with a dynamic label. Absent without such features.
  std::optional<double> Recall() const;
};

struct DriveComparison {
  Sequence sequence;
  absl::Status status;                // if not OK, the fields below are empty
  std::string pixels;                 // name of the scored pixels
  std::vector<MethodResult> methods;  // in the order of the options
  // RANSAC distances at the features, compared with the mask's pixel; empty for tracks.
  RocHistogram at_features;
  LabelCounts labels;                       // likewise
  std::vector<double> shared_milliseconds;  // per frame: features, labels, descriptors
  int64_t frames = 0;
  int64_t frames_of_prior = 0;       // not scored: before the first frame with labels
  int64_t frames_without_truth = 0;  // not scored
  int64_t frames_of_void = 0;        // not scored: the truth is void in them
  int64_t frames_of_one_class = 0;   // scored, but without an AUC
  int64_t points_outside = 0;
};

// FailedPrecondition if no frame can be scored, if masks differ in size from their frames (the
// message says how many), or if the truth belongs to the frames of another drive. Cancelled if
// `after_frame` returns false.
absl::StatusOr<DriveComparison> CompareMethods(std::shared_ptr<kernels::Context> context,
                                               const Sequence& sequence,
                                               const ComparisonOptions& options,
                                               const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_DRIVE_COMPARISON_H_
