// Labels from evidence along tracks.
//
//   1. grey, equalised picture                                   vision/frame/equalization.h
//   2. a grid followed by dense flow from the frame before,
//      chained into tracks                                       vision/features, tracking
//   3. the camera's motion from the frame `frame_gap` before     vision/trajectory
//   4. evidence along the tracks and from the frames ahead,
//      fused into one probability per place                      evidence_labeller.h
//
// The state is about 3 MB (labeller_state.h).
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/focal_learner.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/gap_choice.h"
#include "vision/labelling/mover_memory.h"
#include "vision/labelling/outlook.h"
#include "vision/labelling/pair_motions.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/trajectory/ground_search.h"
#include "vision/trajectory/ground_speed.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

inline FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options) {
  FlowGridOptions grid;
  grid.stride_pixels = FrameLabellerOptions::kFlowStridePixels;
  grid.quality = options.flow_quality;
  grid.searches_lost = options.searches_lost;
  grid.ignored = options.ignored;
  return grid;
}

inline TwoViewMotionOptions MotionOptionsOf(const TravelPrior& travel) {
  TwoViewMotionOptions motion;
  motion.travel = travel;
  // With a vehicle's direction of travel, traffic is not mistaken for the static scene anyway.
  if (travel.IsOfVehicle()) motion.memory = 0.0;
  return motion;
}

// Null if the drive's fixed pattern is not known, and where the camera is on no vehicle: then there is
// no windscreen, and what agrees with the pattern is a mover that the camera follows, or chance.
inline std::shared_ptr<const FixedPattern> PatternOf(const FrameLabellerOptions& options) {
  if (options.fixed_pattern.empty() || !options.travel.IsOfVehicle()) return nullptr;
  cv::Mat1f median;
  options.fixed_pattern.convertTo(median, CV_32F);
  return std::make_shared<FixedPattern>(median);
}

// Of a focal length that is not known yet. One that is too long hardly changes which places fit: the
// turn then looks like a shift. One that is too short bends it, so it is longer than most.
inline constexpr double kAssumedFocalRatio = 1.4;

class TrackLabeller : public FrameLabeller {
 public:
  static absl::StatusOr<std::unique_ptr<FrameLabeller>> Create(const FrameLabellerOptions& options);

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const override;
  absl::Status Prepare(const ExtractedFrame& first, const ExtractedFrame& second) const override;
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) override;
  absl::Status Prime(const Frame& frame) override;
  LearntCamera learnt_camera() const override { return focal_ ? focal_->learnt() : LearntCamera(); }
  std::string state() const override;
  absl::Status Restore(absl::string_view state) override;
  const FrameLabellerOptions& options() const override { return options_; }

 private:
  using Pictures = std::vector<std::shared_ptr<const ExtractedFrame>>;

  // focal: absent where the focal length is not learnt here.
  TrackLabeller(const FrameLabellerOptions& options, std::optional<FocalLearner> focal)
      : options_(options),
        pattern_(PatternOf(options)),
        pair_motions_(GridOptionsOf(options), MotionOptionsOf(options.travel), pattern_),
        evidence_(options),
        focal_(std::move(focal)) {}

  // How a frame is seen beside its own pair.
  struct Sight {
    View behind;          // of a pair of more than one frame: from the frame before; else empty
    TwoViewMotion world;  // of the pair; found if it is known or MotionOfTracks has set it
    Outlook outlook;
  };

  const ExtractedFrame* Last() const { return history_.empty() ? nullptr : history_.back().get(); }
  absl::Status Push(std::shared_ptr<const ExtractedFrame> frame);
  // Frame gap of the pair that ends in the current frame. before: number of frames before it.
  int Gap(int before) const {
    return options_.frame_gap > 0 ? options_.frame_gap : std::min(gap_.gap, before);
  }
  const ExtractedFrame* InHistory(int64_t index) const {
    for (const auto& frame : history_) {
      if (frame->frame.index == index) return frame.get();
    }
    return nullptr;
  }
  // before: the frame before the current one.
  absl::Status LabelTracks(const ExtractedFrame& before, const ExtractedFrame& frame,
                           const Pictures& ahead, LabelledFrame& result);
  // Labels from the pictures ahead alone; the outcome stays as it is if none of them can be used.
  absl::Status LabelFromAhead(const ExtractedFrame& frame, const Pictures& ahead,
                              LabelledFrame& result);
  bool IsFocalKnown() const { return !focal_ || focal_->learnt().focal_ratio > 0.0; }
  // Over the longer side; given, learnt or assumed.
  double focal_ratio() const {
    if (!IsFocalKnown()) return kAssumedFocalRatio;
    return focal_ ? focal_->learnt().focal_ratio : options_.focal_ratio;
  }
  // Given or learnt; need not be known.
  const TravelPrior& travel() const { return focal_ ? focal_->learnt().travel : options_.travel; }
  // For the frames after this one. outcome: without the pictures ahead.
  void LearnCamera(const ExtractedFrame& frame, LabelOutcome outcome);
  // The direction of travel, by the motion of the pair that ends at `seconds`.
  void LearnTravel(const TwoViewMotion& motion, double seconds);
  // The motion between the two frames of the pair. Sets `world` if it is not known. Returns whether it
  // is trusted.
  bool MotionOfTracks(const std::vector<TrackedPoint>& points, const ExtractedFrame& frame,
                      const MovedNodes& moved, TwoViewMotion& world, LabelledFrame& result);
  absl::StatusOr<Sight> SightOf(const ExtractedFrame& before, const ExtractedFrame& frame,
                                const Pictures& ahead, absl::Span<const float> moved, int gap,
                                StageMilliseconds& milliseconds);
  Pinhole Camera(cv::Size size) const;
  // The step from `before`, the frame before, where the pair's motion is trusted. Unknown if the pair
  // is longer and nothing is known of the way from `before`.
  CameraStep StepOf(const ExtractedFrame& before, const ExtractedFrame& frame, int gap,
                    const Sight& sight, const std::vector<TrackedPoint>& points) const;
  // Updates the speed of the ground. back: the motion from `frame` to `before`; null: not known.
  // observation: without the pictures.
  void ObserveGround(const ExtractedFrame& before, const ExtractedFrame& frame,
                     const TwoViewMotion* back, const View& far, const Pictures& ahead,
                     GroundObservation observation);
  // Adds pictures before the last of `pictures`, which is of the frame before `frame`, as far as
  // the motions between them are known and there are fewer than for a frame with pictures ahead.
  void AddEarlier(const ExtractedFrame& frame, std::vector<GroundPicture>& pictures) const;
  // Sets is_unbounded of the points where the frame agrees with the drive's fixed pattern, and of
  // those on lines along the direction of travel. back: the motion to the frame of `before`; need
  // not be found.
  void MarkUnbounded(const ExtractedFrame& frame, const TwoViewMotion& back, const Outlook& outlook,
                     std::vector<TrackedPoint>& points);
  // Sets the motion's ground by its speed over the drive of a vehicle. seconds: of the pair.
  // ground_heights stays what the pair shows where the two agree.
  void BoundGround(double seconds, TwoViewMotion& motion) const;
  // The three above for the pair of `first`, which may be null, and `frame`.
  void UseGround(const ExtractedFrame& before, const ExtractedFrame* first,
                 const ExtractedFrame& frame, const Pictures& ahead, int gap, Sight& sight,
                 std::vector<TrackedPoint>& points);

  const FrameLabellerOptions options_;
  const std::shared_ptr<const FixedPattern> pattern_;
  std::deque<std::shared_ptr<const ExtractedFrame>> history_;  // at most frame_gap, oldest first
  GapState gap_;
  MoverMemory movers_;
  GroundSpeed ground_;
  mutable PairMotions pair_motions_;  // its motions are part of state()
  EvidenceLabeller evidence_;         // its last picture is that of the last frame of `history_`
  std::optional<FocalLearner> focal_;
};

}  // namespace egosieve::vision
