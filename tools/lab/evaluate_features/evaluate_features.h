// Scores the labels of features against truth, without a model that learns from them. The front end
// runs over a sequence as in a drive, and every scored frame gives
//
//   residual   AUC of the chosen motion model's distance, movers against the rest
//   rejected   the same of the motion model that was not chosen
//   label      AUC of the probability of moving
//   plain      AUC of plain OpenCV's distance at its own matches (plain_ransac.h)
//
// at the features, if the truth is masks, or at the labelled tracks. Means are over the frames with
// both kinds of points. The choice of motion model is judged in frames that have both models
// (ChoiceVerdict, vision/labelling/feature_evaluation.h).
#ifndef EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_H_
#define EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/lab/evaluate_features/feature_sequence.h"
#include "vision/labelling/feature_evaluation.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::tools {

struct EvaluateFeaturesOptions {
  vision::FrameLabellerOptions labeller;
  int every = 1;             // every k-th frame is scored; all are labelled; positive
  bool plain_ransac = true;  // costs more than all other work

  absl::Status Validate() const;
};

struct FeatureFrame {
  int64_t index = 0;    // index of the input frame
  std::string outcome;  // vision::Name(LabelOutcome)
  std::string reason;
  vision::MotionModelKind motion_model = vision::MotionModelKind::kNone;
  vision::FeatureScore score;
  std::optional<vision::ChoiceVerdict> verdict;
  std::optional<double> plain_auc;
};

struct SequenceScore {
  std::string name;
  std::vector<FeatureFrame> frames;  // frames with truth that were to be scored
  int64_t frames_without_truth = 0;
  int64_t frames_damaged = 0;

  int64_t CountVerdicts(vision::ChoiceVerdict verdict) const;
  // Frames in which the chosen model's AUC is not below the other's; ties count.
  int64_t CountNotBelow() const;
  int64_t CountUnlabelled() const;
  std::map<std::string, int64_t> CountMotionModels() const;
};

// One of the four figures; means are over the frames that have it.
using AucOf = std::function<std::optional<double>(const FeatureFrame&)>;
std::optional<double> MeanAuc(const std::vector<FeatureFrame>& frames, const AucOf& auc_of);
std::optional<double> ResidualAuc(const FeatureFrame& frame);
std::optional<double> RejectedAuc(const FeatureFrame& frame);
std::optional<double> LabelAuc(const FeatureFrame& frame);
std::optional<double> PlainAuc(const FeatureFrame& frame);

// `after_frame` is called after each frame; returning false cancels. FailedPrecondition if no frame
// has truth.
absl::StatusOr<SequenceScore> EvaluateSequence(const FeatureSequence& sequence,
                                               const EvaluateFeaturesOptions& options,
                                               const std::function<bool()>& after_frame);
absl::StatusOr<std::vector<SequenceScore>> EvaluateSequences(
    const std::vector<FeatureSequence>& sequences, const EvaluateFeaturesOptions& options,
    const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_H_
