// How well features are labelled, against truth, without a model that learns from them: the front
// end runs over a sequence as it does in a drive, and every scored frame gives
//
//   residual   AUC of the chosen motion model's distance, movers against the rest
//   rejected   the same of the motion model that was not chosen
//   label      AUC of the probability of being dynamic
//   plain      AUC of plain OpenCV's distance at its own matches (plain_ransac.h)
//
// at the features, for masks, or at the labelled tracks. Means are over the frames that have both
// kinds of points; the choice of motion model is judged where there are both models
// (ChoiceVerdict, vision/labelling/feature_evaluation.h).
#ifndef EGOSIEVE_TOOLS_EVALUATE_FEATURES_EVALUATE_FEATURES_H_
#define EGOSIEVE_TOOLS_EVALUATE_FEATURES_EVALUATE_FEATURES_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/evaluate_features/feature_sequence.h"
#include "vision/labelling/feature_evaluation.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::tools {

struct EvaluateFeaturesOptions {
  vision::FrameLabellerOptions labeller;
  int every = 1;             // scored is every k-th frame; all are labelled; positive
  bool plain_ransac = true;  // costs more than all the rest

  absl::Status Validate() const;
};

struct FeatureFrame {
  int64_t index = 0;    // of the frame handed in
  std::string outcome;  // vision::Name(LabelOutcome)
  std::string reason;
  vision::MotionModelKind motion_model = vision::MotionModelKind::kNone;
  vision::FeatureScore score;
  std::optional<vision::ChoiceVerdict> verdict;
  std::optional<double> plain_auc;
};

struct SequenceScore {
  std::string name;
  std::vector<FeatureFrame> frames;  // that have truth and were to be scored
  int64_t frames_without_truth = 0;
  int64_t frames_damaged = 0;

  int64_t CountVerdicts(vision::ChoiceVerdict verdict) const;
  // Frames in which the chosen model's AUC is not below the other's, ties at any digit included.
  int64_t CountNotBelow() const;
  int64_t CountJudged() const;
  int64_t CountUnlabelled() const;
  std::map<std::string, int64_t> CountMotionModels() const;
};

// Of one of the four figures, over the frames that have it.
using AucOf = std::function<std::optional<double>(const FeatureFrame&)>;
std::optional<double> MeanAuc(const std::vector<FeatureFrame>& frames, const AucOf& auc_of);
std::optional<double> ResidualAuc(const FeatureFrame& frame);
std::optional<double> RejectedAuc(const FeatureFrame& frame);
std::optional<double> LabelAuc(const FeatureFrame& frame);
std::optional<double> PlainAuc(const FeatureFrame& frame);

// `after_frame` is called after each frame; false cancels. FailedPrecondition where no frame has
// truth.
absl::StatusOr<SequenceScore> EvaluateSequence(const FeatureSequence& sequence,
                                               const EvaluateFeaturesOptions& options,
                                               const std::function<bool()>& after_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_FEATURES_EVALUATE_FEATURES_H_
