#include "vision/labelling/frame_labeller.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/repeated_picture.h"
#include "vision/labelling/frame_labeller_implementation.h"
#include "vision/labelling/frame_step.h"
#include "vision/labelling/labeller_state.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {
absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Implementation::Extract(
    const Frame& frame) const {
  if (frame.image.empty() || frame.image.type() != CV_8UC3) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, ": the image is empty or not 8-bit BGR"));
  }
  auto extracted = std::make_shared<ExtractedFrame>();
  Stopwatch watch;
  extracted->frame = frame;
  extracted->grey = EqualizedGrey(ReducePicture(frame.image, options_.longest_side_pixels),
                                  options_.equalization);
  extracted->equalization_milliseconds = watch.LapMilliseconds();
  extracted->feature_options.count = options_.feature_count;
  extracted->feature_options.threads = options_.threads;
  if (options_.features == FeatureSource::kSiftCorners ||
      options_.features == FeatureSource::kBoth) {
    if (!extracted->features().ok()) return extracted->features().status();
  }
  return std::shared_ptr<const ExtractedFrame>(std::move(extracted));
}

absl::Status FrameLabeller::Implementation::Prepare(const ExtractedFrame& first,
                                                    const ExtractedFrame& second) {
  const cv::Size size = second.grey.size();
  if (!gathers_ || options_.features == FeatureSource::kSiftCorners || first.grey.size() != size ||
      !IsLargeEnoughForFlow(size) || SamePixels(first.frame.image, second.frame.image)) {
    return absl::OkStatus();
  }
  FlowCache& flows = pair_motions_.flows();
  EGOSIEVE_RETURN_IF_ERROR(flows.Grid(first, second, /*anchor_second=*/true).status());
  // One that is learnt may change while this runs.
  const bool knows_camera = options_.WantsCamera() && options_.focal_ratio > 0.0;
  if (!knows_camera) return absl::OkStatus();
  return flows.Grid(first, second, /*anchor_second=*/false).status();
}

absl::Status FrameLabeller::Implementation::CheckOrder(const ExtractedFrame& frame) const {
  if (!history_.empty() && frame.frame.index <= history_.back()->frame.index) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.frame.index, " came after frame ",
                     history_.back()->frame.index, "; indices must grow"));
  }
  return absl::OkStatus();
}

absl::Status FrameLabeller::Implementation::Push(std::shared_ptr<const ExtractedFrame> frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(*frame));
  if (!history_.empty() && SizeBefore() != frame->frame.image.size()) history_.clear();
  // Skipped for frames that were already labelled or are part of the restored state.
  if (gathers_ && evidence_.last_frame_index() < frame->frame.index) {
    evidence_.Begin(frame->frame.index);
    movers_.Forget();
  }
  if (!history_.empty() && SamePixels(history_.back()->frame.image, frame->frame.image)) {
    // The later steps are between different pictures: the repeat takes the place of the first.
    auto repeat = std::make_shared<ExtractedFrame>();
    repeat->frame = frame->frame;
    repeat->frame.time_seconds = history_.back()->frame.time_seconds;
    repeat->grey = frame->grey;
    repeat->feature_options = frame->feature_options;
    history_.back() = std::move(repeat);
    return absl::OkStatus();
  }
  history_.push_back(std::move(frame));
  while (static_cast<int>(history_.size()) > options_.HistoryFrames()) history_.pop_front();
  return absl::OkStatus();
}

absl::Status FrameLabeller::Implementation::Prime(std::shared_ptr<const ExtractedFrame> frame) {
  const std::shared_ptr<const ExtractedFrame> primed = frame;
  EGOSIEVE_RETURN_IF_ERROR(Push(std::move(frame)));
  if (focal_) focal_->Prime(primed->frame, primed->grey);
  return absl::OkStatus();
}

void FrameLabeller::Implementation::LearnCamera(const ExtractedFrame& frame, LabelOutcome outcome) {
  if (!focal_) return;
  if (outcome == LabelOutcome::kDuplicateFrame) return focal_->Repeat(frame.frame.index);
  if (outcome == LabelOutcome::kTooFewFeatures || outcome == LabelOutcome::kTooFewMatches) {
    focal_->EndScene();
  }
  const bool was_calibrated = IsCalibrated();
  if (!focal_->Add(frame.frame, frame.grey)) return;
  pair_motions_.SetMotionOptions(MotionOptionsOf(options_, travel()));
  // Parallax of a selected model is measured in another way.
  if (!was_calibrated) gap_.has_parallax = false;
}

std::string FrameLabeller::Implementation::state() const {
  LabellerState state;
  state.mixture = mixture_;
  state.gap = gap_;
  state.motion = motion_;
  state.ground = ground_.probabilities();
  state.moved = movers_.nodes();
  state.motions = pair_motions_.known();
  state.evidence = evidence_.state();
  if (focal_) state.focal = focal_->state();
  return ToBytes(state);
}

absl::Status FrameLabeller::Implementation::Restore(absl::string_view bytes) {
  EGOSIEVE_ASSIGN_OR_RETURN(LabellerState state, FromBytes(bytes));
  GroundSpeed ground;
  if (!ground.Restore(state.ground)) {
    return absl::InvalidArgumentError("the labeller's state holds no speed of the ground");
  }
  if (state.focal.has_value() != focal_.has_value()) {
    return absl::InvalidArgumentError(
        focal_ ? "the labeller's state is one of a focal length that was known beforehand"
               : "the labeller's state is one of a focal length that is learnt on the way");
  }
  EGOSIEVE_RETURN_IF_ERROR(evidence_.Restore(std::move(state.evidence)));
  if (focal_) focal_->Restore(*std::move(state.focal));
  ground_ = ground;
  mixture_ = state.mixture;
  gap_ = state.gap;
  motion_ = std::move(state.motion);
  history_.clear();
  movers_.Restore(std::move(state.moved));
  pair_motions_ =
      PairMotions(GridOptionsOf(options_), MotionOptionsOf(options_, travel()), pattern_);
  pair_motions_.Restore(state.motions);
  return absl::OkStatus();
}

absl::StatusOr<LabelledFrame> FrameLabeller::Implementation::Label(
    std::shared_ptr<const ExtractedFrame> frame, const Pictures& ahead) {
  if (frame == nullptr) return absl::InvalidArgumentError("no frame to label");
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(*frame));
  LabelledFrame result;
  result.frame_index = frame->frame.index;
  result.labelled = frame->frame;
  result.times.equalization_milliseconds = frame->equalization_milliseconds;
  const cv::Size now = frame->frame.image.size();
  if (!history_.empty() && SizeBefore() != now) {
    const cv::Size before = SizeBefore();
    SetOutcome(LabelOutcome::kSizeChanged,
               absl::StrCat("the frame is ", now.width, "x", now.height, ", those before it ",
                            before.width, "x", before.height),
               result);
    motion_ = MotionField();
  } else if (history_.empty() ||
             (!gathers_ && static_cast<int>(history_.size()) < options_.frame_gap)) {
    SetOutcome(LabelOutcome::kNoPair,
               options_.frame_gap > 1
                   ? absl::StrCat("fewer than ", options_.frame_gap, " frames before this one")
                   : "no frame before this one",
               result);
  } else if (SamePixels(history_.back()->frame.image, frame->frame.image)) {
    SetOutcome(LabelOutcome::kDuplicateFrame, "the same picture as the frame before", result);
    if (gathers_) evidence_.Repeat(frame->frame.index);
  } else if (gathers_) {
    EGOSIEVE_RETURN_IF_ERROR(LabelTracks(*history_.back(), *frame, ahead, result));
  } else {
    EGOSIEVE_RETURN_IF_ERROR(LabelPair(
        *history_[history_.size() - Gap(static_cast<int>(history_.size()))], *frame, result));
  }
  const LabelOutcome outcome = result.outcome;
  if (gathers_ && result.outcome != LabelOutcome::kLabelled &&
      result.outcome != LabelOutcome::kDuplicateFrame &&
      result.outcome != LabelOutcome::kUntrustedMotion) {
    EGOSIEVE_RETURN_IF_ERROR(LabelFromAhead(*frame, ahead, result));
  }
  Stopwatch watch;
  LearnCamera(*frame, outcome);
  result.times.geometry_milliseconds += watch.LapMilliseconds();
  result.doubt = DoubtOf(result);
  EnlargeLabels(frame->grey.size(), now, result);
  const int64_t index = frame->frame.index;
  pair_motions_.Forget(index, history_.empty() ? index : history_.front()->frame.index);
  EGOSIEVE_RETURN_IF_ERROR(Push(std::move(frame)));
  return result;
}

FrameLabeller::FrameLabeller(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
FrameLabeller::~FrameLabeller() = default;

absl::StatusOr<std::unique_ptr<FrameLabeller>> FrameLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  FrameLabellerOptions reduced = options;
  reduced.ignored = ReduceMask(options.ignored, options.longest_side_pixels);
  reduced.windscreen = ReduceMask(options.windscreen, options.longest_side_pixels);
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceLabeller evidence, EvidenceLabeller::Create(reduced));
  std::optional<FocalLearner> focal;
  if (options.LearnsFocalRatio()) focal.emplace(options.ignored, options.equalization);
  return std::unique_ptr<FrameLabeller>(new FrameLabeller(
      std::make_unique<Implementation>(reduced, std::move(evidence), std::move(focal))));
}

absl::StatusOr<LabelledFrame> FrameLabeller::Process(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return Label(std::move(extracted));
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Extract(
    const Frame& frame) const {
  return implementation_->Extract(frame);
}

absl::Status FrameLabeller::Prepare(const ExtractedFrame& first,
                                    const ExtractedFrame& second) const {
  return implementation_->Prepare(first, second);
}

absl::StatusOr<LabelledFrame> FrameLabeller::Label(
    std::shared_ptr<const ExtractedFrame> frame,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) {
  return implementation_->Label(std::move(frame), ahead);
}

absl::Status FrameLabeller::Prime(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return implementation_->Prime(std::move(extracted));
}

LearntCamera FrameLabeller::learnt_camera() const { return implementation_->learnt_camera(); }

std::string FrameLabeller::state() const { return implementation_->state(); }

absl::Status FrameLabeller::Restore(absl::string_view state) {
  return implementation_->Restore(state);
}

const FrameLabellerOptions& FrameLabeller::options() const { return implementation_->options(); }

}  // namespace egosieve::vision
