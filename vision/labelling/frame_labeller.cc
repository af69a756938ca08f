#include "vision/labelling/frame_labeller.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/sampling.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_step.h"
#include "vision/labelling/gap_choice.h"
#include "vision/labelling/label_rule.h"
#include "vision/labelling/labeller_state.h"
#include "vision/labelling/outlook.h"
#include "vision/labelling/pair_builder.h"
#include "vision/labelling/pair_motions.h"
#include "vision/labelling/place_labels.h"
#include "vision/labelling/stopwatch.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr uint64_t kGeometryStep = 1;
constexpr int kNoGap = 1 << 20;  // pictures that no track reaches back

void SetOutcome(LabelOutcome outcome, std::string reason, LabelledFrame& result) {
  result.outcome = outcome;
  result.reason = std::move(reason);
}

TwoViewMotionOptions MotionOptionsOf(const FrameLabellerOptions& options) {
  TwoViewMotionOptions motion;
  motion.travel = options.travel;
  return motion;
}

cv::Matx33d ToMatx(const Eigen::Matrix3d& m) {
  cv::Matx33d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result(i, j) = m(i, j);
  }
  return result;
}

void RecordMotion(const MotionModel& model, LabelledFrame& result) {
  result.motion_model = model.kind;
  result.motion_matrix = ToMatx(model.matrix);
  result.rejected_model = model.rejected_kind;
  result.rejected_matrix = ToMatx(model.rejected_matrix);
  result.motion_trusted = model.trusted;
  result.parallax_pixels = model.parallax_pixels;
  result.inlier_count = model.inlier_count;
  if (!model.trusted) SetOutcome(LabelOutcome::kUntrustedMotion, model.reason, result);
}

}  // namespace

class FrameLabeller::Implementation {
 public:
  using Pictures = std::vector<std::shared_ptr<const ExtractedFrame>>;

  Implementation(const FrameLabellerOptions& options, EvidenceLabeller evidence)
      : options_(options),
        gathers_(!options.evidence.IsEpipolarAlone()),
        pair_motions_(GridOptionsOf(options), MotionOptionsOf(options)),
        evidence_(std::move(evidence)) {}

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  absl::StatusOr<LabelledFrame> Label(std::shared_ptr<const ExtractedFrame> frame,
                                      const Pictures& ahead);
  absl::Status Push(std::shared_ptr<const ExtractedFrame> frame);

  std::string state() const;
  absl::Status Restore(absl::string_view state);
  const FrameLabellerOptions& options() const { return options_; }

 private:
  absl::Status CheckOrder(const ExtractedFrame& frame) const;
  // Frames between the two of the pair that ends in the current one; `before`: how many there are.
  int Gap(int before) const {
    return options_.frame_gap > 0 ? options_.frame_gap : std::min(gap_.gap, before);
  }
  const ExtractedFrame* InHistory(int64_t index) const {
    for (const auto& frame : history_) {
      if (frame->frame.index == index) return frame.get();
    }
    return nullptr;
  }
  absl::Status LabelPair(const ExtractedFrame& first, const ExtractedFrame& second,
                         LabelledFrame& result);
  // The same with evidence along tracks; `before` is the frame before.
  absl::Status LabelTracks(const ExtractedFrame& before, const ExtractedFrame& frame,
                           const Pictures& ahead, LabelledFrame& result);
  // From the pictures ahead alone; the outcome stays as it is where they say nothing.
  absl::Status LabelFromAhead(const ExtractedFrame& frame, const Pictures& ahead,
                              LabelledFrame& result);
  // Whether there is enough to go on; else the outcome is set.
  bool IsEnough(const FramePairs& pairs, LabelledFrame& result) const;
  absl::StatusOr<MotionModel> FindMotion(const std::vector<PointPair>& pairs, int64_t frame_index,
                                         LabelledFrame& result) const;
  // Empty where the motion is not calibrated, or the grid of flow not used.
  absl::StatusOr<Outlook> OutlookOf(const ExtractedFrame& frame, const Pictures& ahead);
  Pinhole Camera(cv::Size size) const;
  void ObserveGap(const MotionModel& model, int gap);
  // What the next pair is predicted from: nothing, where the motion is not to be believed.
  void KeepMotion(const FramePairs& pairs, int pictures, cv::Size size, bool trusted);

  const FrameLabellerOptions options_;
  const bool gathers_;  // evidence beyond the epipolar distance
  std::deque<std::shared_ptr<const ExtractedFrame>> history_;  // at most frame_gap, oldest first
  MixtureState mixture_;
  GapState gap_;
  MotionField motion_;        // of the last pair
  PairMotions pair_motions_;  // no state: what it holds can be computed again
  // Its last picture is that of the history's last frame. Not used where !gathers_.
  EvidenceLabeller evidence_;
};

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Implementation::Extract(
    const Frame& frame) const {
  if (frame.image.empty() || frame.image.type() != CV_8UC3) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, ": the image is empty or not 8-bit BGR"));
  }
  auto extracted = std::make_shared<ExtractedFrame>();
  Stopwatch watch;
  extracted->frame = frame;
  extracted->grey = EqualizedGrey(frame.image, options_.equalization);
  extracted->equalization_milliseconds = watch.LapMilliseconds();
  extracted->feature_options.count = options_.feature_count;
  extracted->feature_options.threads = options_.threads;
  if (options_.features == FeatureSource::kSiftCorners ||
      options_.features == FeatureSource::kBoth) {
    if (!extracted->features().ok()) return extracted->features().status();
  }
  return std::shared_ptr<const ExtractedFrame>(std::move(extracted));
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
  if (!history_.empty() && history_.back()->grey.size() != frame->grey.size()) history_.clear();
  // Not so for a frame that was labelled, or that the restored state knows.
  if (gathers_ && evidence_.last_frame_index() < frame->frame.index) {
    evidence_.Begin(frame->frame.index);
  }
  history_.push_back(std::move(frame));
  while (static_cast<int>(history_.size()) > options_.HistoryFrames()) history_.pop_front();
  return absl::OkStatus();
}

std::string FrameLabeller::Implementation::state() const {
  LabellerState state;
  state.mixture = mixture_;
  state.gap = gap_;
  state.motion = motion_;
  state.evidence = evidence_.state();
  return ToBytes(state);
}

absl::Status FrameLabeller::Implementation::Restore(absl::string_view bytes) {
  EGOSIEVE_ASSIGN_OR_RETURN(LabellerState state, FromBytes(bytes));
  EGOSIEVE_RETURN_IF_ERROR(evidence_.Restore(std::move(state.evidence)));
  mixture_ = state.mixture;
  gap_ = state.gap;
  motion_ = std::move(state.motion);
  history_.clear();
  pair_motions_ = PairMotions(GridOptionsOf(options_), MotionOptionsOf(options_));
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
  if (!history_.empty() && history_.back()->grey.size() != frame->grey.size()) {
    const cv::Size before = history_.back()->grey.size(), now = frame->grey.size();
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
  if (gathers_ && result.outcome != LabelOutcome::kLabelled &&
      result.outcome != LabelOutcome::kDuplicateFrame &&
      result.outcome != LabelOutcome::kUntrustedMotion) {
    EGOSIEVE_RETURN_IF_ERROR(LabelFromAhead(*frame, ahead, result));
  }
  if (result.outcome != LabelOutcome::kLabelled) result.doubt = DoubtOf(result, nullptr);
  pair_motions_.Forget(frame->frame.index);
  EGOSIEVE_RETURN_IF_ERROR(Push(std::move(frame)));
  return result;
}

bool FrameLabeller::Implementation::IsEnough(const FramePairs& pairs, LabelledFrame& result) const {
  result.feature_count = pairs.feature_count;
  result.match_count = static_cast<int64_t>(pairs.labelled.size());
  result.times.features_milliseconds = pairs.features_milliseconds;
  result.times.matching_milliseconds = pairs.matching_milliseconds;
  if (result.feature_count < options_.minimum_matches) {
    SetOutcome(LabelOutcome::kTooFewFeatures,
               absl::StrCat("only ", result.feature_count, " features: no texture"), result);
    return false;
  }
  const bool enough = pairs.match_count >= options_.minimum_matches;
  if (enough && pairs.scene.IsOneScene()) return true;
  const SceneAgreement::Areas areas = pairs.scene.CountAreas();
  SetOutcome(LabelOutcome::kTooFewMatches,
             enough ? absl::StrFormat("another scene: %d of %d areas agree with the frame before",
                                      areas.holding, areas.judged)
                    : absl::StrFormat("only %d of %d features have a match", pairs.match_count,
                                      pairs.feature_count),
             result);
  return false;
}

absl::StatusOr<MotionModel> FrameLabeller::Implementation::FindMotion(
    const std::vector<PointPair>& pairs, int64_t frame_index, LabelledFrame& result) const {
  Stopwatch watch;
  MotionModelOptions motion;
  motion.choice = options_.motion_model;
  motion.seed = MixSeed(options_.seed, static_cast<uint64_t>(frame_index), kGeometryStep);
  EGOSIEVE_ASSIGN_OR_RETURN(MotionModel model, EstimateMotionModel(pairs, motion));
  result.times.geometry_milliseconds = watch.LapMilliseconds();
  RecordMotion(model, result);
  return model;
}

Pinhole FrameLabeller::Implementation::Camera(cv::Size size) const {
  return Pinhole::Of(size, options_.focal_ratio * std::max(size.width, size.height));
}

void FrameLabeller::Implementation::ObserveGap(const MotionModel& model, int gap) {
  if (options_.frame_gap > 0 || !model.trusted) return;
  ObserveParallax(model.parallax_pixels, gap, FrameLabellerOptions::kLongestAutoGap,
                  options_.IsCalibrated() ? kCalibratedGap : kSelectedModelGap, gap_);
}

void FrameLabeller::Implementation::KeepMotion(const FramePairs& pairs, int pictures, cv::Size size,
                                               bool trusted) {
  const bool is_used = options_.windowed_search && options_.features != FeatureSource::kFlow;
  motion_ = is_used && trusted ? MakeMotionField(pairs.geometry, pictures, size) : MotionField();
}

absl::Status FrameLabeller::Implementation::LabelPair(const ExtractedFrame& first,
                                                      const ExtractedFrame& second,
                                                      LabelledFrame& result) {
  result.first_index = first.frame.index;
  result.second_index = second.frame.index;
  const int gap = Gap(static_cast<int>(history_.size()));
  EGOSIEVE_ASSIGN_OR_RETURN(const FramePairs pairs, BuildPairs(first, second, motion_, gap,
                                                               options_, pair_motions_.flows()));
  motion_ = MotionField();
  if (!IsEnough(pairs, result)) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const MotionModel model,
                            FindMotion(pairs.geometry, second.frame.index, result));
  ObserveGap(model, gap);
  KeepMotion(pairs, gap, second.grey.size(), model.trusted);
  if (!model.trusted) return absl::OkStatus();
  Stopwatch watch;
  const bool on_first = options_.labelled_side == LabelledSide::kFirstFrame;
  LabelByDistance(on_first ? first : second, pairs.labelled, model, options_, mixture_, result);
  result.times.labelling_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::StatusOr<Outlook> FrameLabeller::Implementation::OutlookOf(const ExtractedFrame& frame,
                                                                 const Pictures& ahead) {
  if (!options_.IsCalibrated() || options_.features == FeatureSource::kSiftCorners) {
    return Outlook();
  }
  return LookAhead(frame, ahead, Camera(frame.grey.size()), pair_motions_);
}

absl::Status FrameLabeller::Implementation::LabelFromAhead(const ExtractedFrame& frame,
                                                           const Pictures& ahead,
                                                           LabelledFrame& result) {
  EGOSIEVE_ASSIGN_OR_RETURN(const Outlook outlook, OutlookOf(frame, ahead));
  if (outlook.empty()) return absl::OkStatus();
  Stopwatch watch;
  if (evidence_.last_frame_index() != frame.frame.index) evidence_.Begin(frame.frame.index);
  const std::vector<TrackedPoint> points = evidence_.Points(kNoGap, outlook.links);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const EvidenceResult evidence,
      evidence_.Judge(nullptr, frame, 1, MotionModel(), points, nullptr, Camera(frame.grey.size()),
                      {{outlook.far.frame, &outlook.far.motion, &TrackedPoint::far_ahead},
                       {outlook.near.frame, &outlook.near.motion, &TrackedPoint::near_ahead}}));
  const View& view = outlook.far.frame != nullptr ? outlook.far : outlook.near;
  result.first_index = frame.frame.index;
  result.second_index = view.frame->frame.index;
  RecordMotion(ModelOf(view.motion, Camera(frame.grey.size()), 0), result);
  result.reason.clear();
  LabelByEvidence(frame, points, MotionModel(), evidence, options_, result);
  result.doubt = DoubtOf(result, &view.motion);
  result.times.labelling_milliseconds += watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::Status FrameLabeller::Implementation::LabelTracks(const ExtractedFrame& before,
                                                        const ExtractedFrame& frame,
                                                        const Pictures& ahead,
                                                        LabelledFrame& result) {
  EGOSIEVE_ASSIGN_OR_RETURN(const FramePairs pairs,
                            BuildPairs(before, frame, motion_, 1, options_, pair_motions_.flows()));
  motion_ = MotionField();
  if (!IsEnough(pairs, result)) {
    evidence_.Begin(frame.frame.index);
    return absl::OkStatus();
  }
  EGOSIEVE_RETURN_IF_ERROR(evidence_.Advance(before, frame, pairs));
  const int gap = Gap(evidence_.PicturesBefore());
  if (evidence_.PicturesBefore() < gap) {
    SetOutcome(LabelOutcome::kNoPair, absl::StrCat("fewer than ", gap, " frames before this one"),
               result);
    return absl::OkStatus();
  }
  result.first_index = evidence_.FrameIndexBefore(gap);
  result.second_index = frame.frame.index;
  const Pinhole camera = Camera(frame.grey.size());
  EGOSIEVE_ASSIGN_OR_RETURN(const Outlook outlook, OutlookOf(frame, ahead));
  View behind;
  if (gap > 1 && options_.IsCalibrated() && options_.features != FeatureSource::kSiftCorners) {
    EGOSIEVE_ASSIGN_OR_RETURN(behind, LookBack(before, frame, camera, pair_motions_));
  }
  const std::vector<TrackedPoint> points = evidence_.Points(gap, outlook.links);
  std::vector<PointPair> geometry;
  for (const TrackedPoint& point : points) {
    const cv::Point2f a = point.evidence.before, b = point.evidence.now;
    if (point.is_textured && point.evidence.HasBefore()) geometry.push_back({a.x, a.y, b.x, b.y});
  }
  MotionModel model;
  TwoViewMotion world;
  if (options_.IsCalibrated()) {
    Stopwatch watch;
    world = EstimateTwoViewMotion(geometry, camera, MotionOptionsOf(options_));
    world.ground_slope = GroundSlope(geometry, world, camera);
    model = ModelOf(world, camera, static_cast<int64_t>(geometry.size()));
    RecordMotion(model, result);
    result.times.geometry_milliseconds = watch.LapMilliseconds();
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(model, FindMotion(geometry, frame.frame.index, result));
  }
  ObserveGap(model, gap);
  KeepMotion(pairs, 1, frame.grey.size(), model.trusted);
  Stopwatch watch;
  if (!model.trusted) model.kind = MotionModelKind::kNone;
  EGOSIEVE_ASSIGN_OR_RETURN(
      const EvidenceResult evidence,
      evidence_.Judge(InHistory(result.first_index), frame, gap, model, points,
                      world.found ? &world : nullptr, camera,
                      {{outlook.far.frame, &outlook.far.motion, &TrackedPoint::far_ahead},
                       {outlook.near.frame, &outlook.near.motion, &TrackedPoint::near_ahead},
                       {behind.frame, &behind.motion, &TrackedPoint::near_behind}}));
  result.own_car = OwnCarAreas(evidence_.own_car(), frame.grey.size());
  if (options_.IsCalibrated()) {
    const FrameViews views{before.frame.index,
                           frame.frame.index,
                           gap,
                           model.trusted ? &world : nullptr,
                           &behind,
                           &outlook};
    result.step = StepOf(views, points, camera);
  }
  if (model.trusted || !outlook.empty()) {
    result.reason.clear();
    LabelByEvidence(frame, points, model, evidence, options_, result);
  }
  const View& view = outlook.far.frame != nullptr ? outlook.far : outlook.near;
  result.doubt = DoubtOf(result, view.frame != nullptr ? &view.motion
                                 : world.found         ? &world
                                                       : nullptr);
  result.times.labelling_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

FrameLabeller::FrameLabeller(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
FrameLabeller::~FrameLabeller() = default;

absl::StatusOr<std::unique_ptr<FrameLabeller>> FrameLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceLabeller evidence, EvidenceLabeller::Create(options));
  return std::unique_ptr<FrameLabeller>(
      new FrameLabeller(std::make_unique<Implementation>(options, std::move(evidence))));
}

absl::StatusOr<LabelledFrame> FrameLabeller::Process(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return Label(std::move(extracted));
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Extract(
    const Frame& frame) const {
  return implementation_->Extract(frame);
}

absl::StatusOr<LabelledFrame> FrameLabeller::Label(
    std::shared_ptr<const ExtractedFrame> frame,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) {
  return implementation_->Label(std::move(frame), ahead);
}

absl::Status FrameLabeller::Prime(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return implementation_->Push(std::move(extracted));
}

std::string FrameLabeller::state() const { return implementation_->state(); }

absl::Status FrameLabeller::Restore(absl::string_view state) {
  return implementation_->Restore(state);
}

const FrameLabellerOptions& FrameLabeller::options() const { return implementation_->options(); }

}  // namespace egosieve::vision
