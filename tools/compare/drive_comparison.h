// Several methods on the same features, frames and pixels of one drive, against its truth. Features
// and labels are those of `segment`: with the drive's camera of a first pass and the frames ahead.
#ifndef EGOSIEVE_TOOLS_COMPARE_DRIVE_COMPARISON_H_
#define EGOSIEVE_TOOLS_COMPARE_DRIVE_COMPARISON_H_

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
  EvaluateOptions evaluate;  // its `pixels` must be the grid's
  int64_t max_frames = 0;    // 0: all
};

// One method in one frame of the drive, scored or not.
struct MethodFrame {
  int64_t index = 0;
  std::optional<double> auc;  // absent where the frame was not scored or has one class
  std::optional<double> auc_without_prior;  // likewise, without the location prior
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

// Labels of features, p >= 1/2 being dynamic, against the mask's pixel.
struct LabelCounts {
  int64_t features[2] = {0, 0};  // that lie on the static world, on movers
  int64_t dynamic[2] = {0, 0};   // of those, with a dynamic label

  void Add(const LabelCounts& other);
  // Of the dynamic labels, those on movers. Absent without dynamic labels.
  std::optional<double> Precision() const;
  // Of the features on movers, those with a dynamic label. Absent without such features.
  std::optional<double> Recall() const;
};

struct DriveComparison {
  Sequence sequence;
  absl::Status status;                // why there is nothing below
  std::string pixels;                 // what is scored
  std::vector<MethodResult> methods;  // in the order of the options
  // RANSAC distances at the features themselves, against the mask's pixel there; empty for tracks.
  RocHistogram at_features;
  LabelCounts labels;                       // likewise
  std::vector<double> shared_milliseconds;  // a frame: features, labels, descriptors
  int64_t frames = 0;
  int64_t frames_of_prior = 0;       // not scored: before the first frame with labels
  int64_t frames_without_truth = 0;  // not scored
  int64_t frames_of_void = 0;        // not scored: the truth knows nothing of them
  int64_t frames_of_one_class = 0;   // scored, but without an AUC
  int64_t points_outside = 0;
};

// FailedPrecondition where no frame can be scored, where masks have another size than their frames
// (how many is told), or where the truth lies beside the frames of another drive; Cancelled where
// `after_frame` returns false.
absl::StatusOr<DriveComparison> CompareMethods(std::shared_ptr<kernels::Context> context,
                                               const Sequence& sequence,
                                               const ComparisonOptions& options,
                                               const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_COMPARE_DRIVE_COMPARISON_H_
