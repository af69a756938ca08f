#include "vision/labelling/track_labeller.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/repeated_picture.h"
#include "vision/labelling/label_outcome.h"
#include "vision/labelling/labeller_state.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> TrackLabeller::Extract(
    const Frame& frame) const {
  auto extracted = std::make_shared<ExtractedFrame>();
  EGOSIEVE_RETURN_IF_ERROR(MakeGrey(frame, options_, *extracted));
  return extracted;
}

absl::Status TrackLabeller::Prepare(const ExtractedFrame& first,
                                    const ExtractedFrame& second) const {
  const cv::Size size = second.grey.size();
  if (first.grey.size() != size || !IsLargeEnoughForFlow(size) ||
      SamePixels(first.frame.image, second.frame.image)) {
    return absl::OkStatus();
  }
  FlowCache& flows = pair_motions_.flows();
  EGOSIEVE_RETURN_IF_ERROR(flows.Grid(first, second, /*anchor_second=*/true).status());
  return flows.Grid(first, second, /*anchor_second=*/false).status();
}

absl::Status TrackLabeller::Push(std::shared_ptr<const ExtractedFrame> frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(Last(), *frame));
  // Skipped for frames that were already labelled or are part of the restored state.
  if (evidence_.last_frame_index() < frame->frame.index) {
    evidence_.Begin(frame->frame.index);
    movers_.Forget();
  }
  Remember(std::move(frame), options_.HistoryFrames(), history_);
  return absl::OkStatus();
}

absl::Status TrackLabeller::Prime(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const ExtractedFrame> primed, Extract(frame));
  EGOSIEVE_RETURN_IF_ERROR(Push(primed));
  if (focal_) focal_->Prime(primed->frame, primed->grey);
  return absl::OkStatus();
}

void TrackLabeller::LearnCamera(const ExtractedFrame& frame, LabelOutcome outcome) {
  if (!focal_) return;
  if (outcome == LabelOutcome::kDuplicateFrame) return focal_->Repeat(frame.frame.index);
  if (outcome == LabelOutcome::kTooFewFeatures || outcome == LabelOutcome::kTooFewMatches) {
    focal_->EndScene();
  }
  if (!focal_->Add(frame.frame, frame.grey)) return;
  pair_motions_.SetMotionOptions(MotionOptionsOf(travel()));
}

void TrackLabeller::LearnTravel(const TwoViewMotion& motion, double seconds) {
  if (!focal_ || !motion.HasParallax()) return;
  const Eigen::Vector3d direction = motion.rotation.transpose() * motion.translation;
  if (!focal_->AddDirection(direction, seconds)) return;
  pair_motions_.SetMotionOptions(MotionOptionsOf(travel()));
}

std::string TrackLabeller::state() const {
  LabellerState state;
  state.gap = gap_;
  state.ground = ground_.state();
  state.moved = movers_.nodes();
  state.motions = pair_motions_.known();
  state.evidence = evidence_.state();
  if (focal_) state.focal = focal_->state();
  return ToBytes(state);
}

absl::Status TrackLabeller::Restore(absl::string_view bytes) {
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
  gap_ = state.gap;
  history_.clear();
  movers_.Restore(std::move(state.moved));
  pair_motions_ = PairMotions(GridOptionsOf(options_), MotionOptionsOf(travel()), pattern_);
  pair_motions_.Restore(state.motions);
  return absl::OkStatus();
}

absl::StatusOr<LabelledFrame> TrackLabeller::Label(std::shared_ptr<const ExtractedFrame> frame,
                                                   const Pictures& ahead) {
  if (frame == nullptr) return absl::InvalidArgumentError("no frame to label");
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(Last(), *frame));
  LabelledFrame result = BeginLabels(*frame);
  if (history_.empty()) {
    SetNoPair(options_.frame_gap, result);
  } else if (HasOtherSize(*Last(), *frame, result)) {
    // Labelling starts anew.
  } else if (IsRepeated(*Last(), *frame, result)) {
    evidence_.Repeat(frame->frame.index);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(LabelTracks(*Last(), *frame, ahead, result));
  }
  const LabelOutcome outcome = result.outcome;
  if (outcome != LabelOutcome::kLabelled && outcome != LabelOutcome::kDuplicateFrame &&
      outcome != LabelOutcome::kUntrustedMotion) {
    EGOSIEVE_RETURN_IF_ERROR(LabelFromAhead(*frame, ahead, result));
  }
  Stopwatch watch;
  LearnCamera(*frame, outcome);
  const double flow = pair_motions_.TakeFlowMilliseconds();
  result.milliseconds.features += flow;
  result.milliseconds.geometry += watch.LapMilliseconds() - flow;
  if (result.doubt.empty()) result.doubt = DoubtOf(result);
  ToPixelsOfFrame(*frame, options_.lens.get(), result);
  const int64_t index = frame->frame.index;
  pair_motions_.Forget(index, history_.empty() ? index : history_.front()->frame.index);
  EGOSIEVE_RETURN_IF_ERROR(Push(std::move(frame)));
  return result;
}

absl::StatusOr<std::unique_ptr<FrameLabeller>> TrackLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  FrameLabellerOptions reduced = options;
  if (options.lens != nullptr) reduced.ignored = options.lens->CorrectMask(options.ignored);
  reduced.ignored = ReduceMask(reduced.ignored, options.longest_side_pixels);
  reduced.windscreen = ReduceMask(options.windscreen, options.longest_side_pixels);
  std::optional<FocalLearner> focal;
  if (options.LearnsFocalRatio()) focal.emplace(options.ignored, options.equalization);
  return std::unique_ptr<FrameLabeller>(new TrackLabeller(reduced, std::move(focal)));
}

}  // namespace egosieve::vision
