#include "tools/lab/evaluate_features/evaluate_features.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluate/truth_masks.h"
#include "tools/lab/evaluate_features/plain_ransac.h"
#include "vision/frame/frame_source.h"
#include "vision/geometry/residual.h"

namespace egosieve::tools {
namespace {

using vision::ChoiceVerdict;
using vision::Frame;
using vision::LabelledFrame;

// Scores the frames of one sequence.
class SequenceScorer {
 public:
  SequenceScorer(const EvaluateFeaturesOptions& options, FeatureTruth truth)
      : options_(options), truth_(std::move(truth)) {}

  bool HasTruth(const LabelledFrame& labelled) const {
    return truth_.has_tracks() || truth_.masks.count(labelled.labelled.index) > 0;
  }

  absl::StatusOr<FeatureFrame> Score(const LabelledFrame& labelled, const Frame& first,
                                     const Frame& second) const {
    FeatureFrame frame;
    frame.index = labelled.frame_index;
    frame.outcome = vision::Name(labelled.outcome);
    frame.reason = labelled.reason;
    frame.motion_model = labelled.motion_model;
    cv::Mat1b mask;
    if (!truth_.has_tracks()) {
      EGOSIEVE_ASSIGN_OR_RETURN(mask, ReadTruthMask(truth_.masks.at(labelled.labelled.index),
                                                    labelled.labelled.image.size()));
    }
    if (labelled.outcome == vision::LabelOutcome::kLabelled) {
      frame.score = truth_.has_tracks() ? ScoreAgainstTracks(labelled, truth_.tracks)
                                        : ScoreAgainstMask(labelled, mask);
      frame.verdict = JudgeChoice(frame.score);
    }
    if (options_.plain_ransac) {
      frame.plain_auc = ScorePlain(first, second, labelled.labelled.index == first.index, mask);
    }
    return frame;
  }

 private:
  std::optional<double> ScorePlain(const Frame& first, const Frame& second, bool on_first,
                                   const cv::Mat1b& mask) const {
    const absl::StatusOr<PlainRansac> plain = EstimateByPlainRansac(first.image, second.image);
    if (!plain.ok()) return std::nullopt;
    std::vector<vision::PointPair> pairs;
    std::vector<bool> is_mover;
    if (truth_.has_tracks()) {
      vision::TrackPairs tracks = vision::PairsOfTracks(truth_.tracks, first.index, second.index);
      pairs = std::move(tracks.pairs);
      is_mover = std::move(tracks.is_mover);
    } else {
      for (const vision::PointPair& pair : plain->pairs) {
        const int x = static_cast<int>(std::lround(on_first ? pair.x1 : pair.x2));
        const int y = static_cast<int>(std::lround(on_first ? pair.y1 : pair.y2));
        if (x < 0 || y < 0 || x >= mask.cols || y >= mask.rows) continue;
        if (mask(y, x) == kTruthVoid) continue;
        pairs.push_back(pair);
        is_mover.push_back(mask(y, x) == kTruthDynamic);
      }
    }
    return vision::AreaUnderRoc(
        vision::Residuals(vision::MotionModelKind::kFundamental, plain->fundamental, pairs,
                          vision::EpipolarDistance::kSampson),
        is_mover);
  }

  const EvaluateFeaturesOptions& options_;
  const FeatureTruth truth_;
};

}  // namespace

absl::Status EvaluateFeaturesOptions::Validate() const {
  if (every < 1) {
    return absl::InvalidArgumentError(absl::StrCat("every is ", every, "; it must be positive"));
  }
  return labeller.Validate();
}

int64_t SequenceScore::CountVerdicts(ChoiceVerdict verdict) const {
  return std::count_if(frames.begin(), frames.end(),
                       [&](const FeatureFrame& frame) { return frame.verdict == verdict; });
}

int64_t SequenceScore::CountNotBelow() const {
  return std::count_if(frames.begin(), frames.end(), [](const FeatureFrame& frame) {
    return frame.verdict.has_value() && *frame.score.residual_auc >= *frame.score.rejected_auc;
  });
}

int64_t SequenceScore::CountUnlabelled() const {
  return std::count_if(frames.begin(), frames.end(), [](const FeatureFrame& frame) {
    return frame.outcome != vision::Name(vision::LabelOutcome::kLabelled);
  });
}

std::map<std::string, int64_t> SequenceScore::CountMotionModels() const {
  std::map<std::string, int64_t> counts;
  for (const FeatureFrame& frame : frames) ++counts[vision::Name(frame.motion_model)];
  return counts;
}

std::optional<double> MeanAuc(const std::vector<FeatureFrame>& frames, const AucOf& auc_of) {
  double sum = 0.0;
  int64_t count = 0;
  for (const FeatureFrame& frame : frames) {
    const std::optional<double> auc = auc_of(frame);
    if (!auc.has_value()) continue;
    sum += *auc;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

std::optional<double> ResidualAuc(const FeatureFrame& frame) { return frame.score.residual_auc; }
std::optional<double> RejectedAuc(const FeatureFrame& frame) { return frame.score.rejected_auc; }
std::optional<double> LabelAuc(const FeatureFrame& frame) { return frame.score.label_auc; }
std::optional<double> PlainAuc(const FeatureFrame& frame) { return frame.plain_auc; }

absl::StatusOr<SequenceScore> EvaluateSequence(const FeatureSequence& sequence,
                                               const EvaluateFeaturesOptions& options,
                                               const std::function<bool()>& after_frame) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(FeatureTruth truth, ReadFeatureTruth(sequence));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::unique_ptr<vision::FrameSource> source,
                            vision::OpenFrameSource(sequence.frames));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::unique_ptr<vision::FrameLabeller> labeller,
                            vision::FrameLabeller::Create(options.labeller));
  const SequenceScorer scorer(options, std::move(truth));
  SequenceScore result;
  result.name = sequence.name;
  std::deque<Frame> pair;  // the last frame_gap + 1 frames
  for (int64_t paired = 0;;) {
    EGOSIEVE_ASSIGN_OR_RETURN(const vision::FrameRead read, source->Next());
    if (std::holds_alternative<vision::EndOfFrames>(read)) break;
    if (std::holds_alternative<vision::DamagedFrame>(read)) {
      ++result.frames_damaged;
      continue;
    }
    pair.push_back(std::get<Frame>(read));
    if (static_cast<int>(pair.size()) > options.labeller.frame_gap + 1) pair.pop_front();
    EGOSIEVE_ASSIGN_OR_RETURN(const LabelledFrame labelled, labeller->Process(pair.back()));
    if (labelled.outcome != vision::LabelOutcome::kNoPair && paired++ % options.every == 0) {
      if (scorer.HasTruth(labelled)) {
        EGOSIEVE_ASSIGN_OR_RETURN(FeatureFrame frame,
                                  scorer.Score(labelled, pair.front(), pair.back()));
        result.frames.push_back(std::move(frame));
      } else {
        ++result.frames_without_truth;
      }
    }
    if (!after_frame()) return absl::CancelledError("interrupted");
  }
  if (result.frames.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        sequence.frames, ": no frame that makes a pair has truth in ", sequence.truth));
  }
  return result;
}

absl::StatusOr<std::vector<SequenceScore>> EvaluateSequences(
    const std::vector<FeatureSequence>& sequences, const EvaluateFeaturesOptions& options,
    const std::function<bool()>& after_frame) {
  std::vector<SequenceScore> scores;
  for (const FeatureSequence& sequence : sequences) {
    EGOSIEVE_ASSIGN_OR_RETURN(SequenceScore score,
                              EvaluateSequence(sequence, options, after_frame));
    scores.push_back(std::move(score));
  }
  return scores;
}

}  // namespace egosieve::tools
