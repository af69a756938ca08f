// Labels from evidence gathered along tracks.
//
//   1. links between the last two frames continue the tracks       vision/tracking
//   2. the pair's other frame: g pictures ago, by the track        frame_labeller.h
//   3. the camera's motion between the two, from the tracks        vision/geometry
//   4. evidence and its probability                                vision/evidence
//
// Pictures are counted, not frame numbers: a repeated picture is no step, and frames that are
// missing make the step longer. Grid nodes and features are tracked side by side; a source that
// gave nothing for a picture loses its tracks.
#ifndef EGOSIEVE_VISION_LABELLING_EVIDENCE_LABELLER_H_
#define EGOSIEVE_VISION_LABELLING_EVIDENCE_LABELLER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/pair_builder.h"
#include "vision/labelling/pair_motions.h"
#include "vision/tracking/feature_tracker.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {

struct EvidenceLabellerState {
  int64_t picture = -1;                // of the last one taken in; -1: none
  std::vector<int64_t> frame_indices;  // of the pictures that tracks may reach, oldest first
  GridTrackerState grid;
  FeatureTrackerState features;
  EvidenceState evidence;
};

inline const cv::Point2f kUnknownPlace{EvidencePoint::kUnknown, EvidencePoint::kUnknown};

// A place that a track has reached, or that a picture near it follows.
struct TrackedPoint {
  EvidencePoint evidence;
  // Where only a picture other than the pair's follows the place; NaN elsewhere.
  cv::Point2f far_ahead = kUnknownPlace, near_ahead = kUnknownPlace, near_behind = kUnknownPlace;
  bool is_textured = true;
  bool is_supported = true;  // enough places around it could be followed as well
};

// Another picture, the camera's motion from the current one to it, and the points' places in it.
struct OtherView {
  const ExtractedFrame* frame = nullptr;
  const TwoViewMotion* motion = nullptr;
  cv::Point2f TrackedPoint::*place = nullptr;
};

class EvidenceLabeller {
 public:
  static absl::StatusOr<EvidenceLabeller> Create(const FrameLabellerOptions& options);

  // A picture that nothing leads to: the drive's first, or the first behind a cut.
  void Begin(int64_t frame_index);
  // The last picture once more.
  void Repeat(int64_t frame_index) { state_.frame_indices.back() = frame_index; }
  // Step 1. pairs: from `before`, the last picture, to `frame`.
  absl::Status Advance(const ExtractedFrame& before, const ExtractedFrame& frame,
                       const FramePairs& pairs);

  // Of the last picture; -1: none.
  int64_t last_frame_index() const {
    return state_.frame_indices.empty() ? -1 : state_.frame_indices.back();
  }
  // How many pictures back any track may reach.
  int PicturesBefore() const { return static_cast<int>(state_.frame_indices.size()) - 1; }
  int64_t FrameIndexBefore(int pictures) const {
    return state_.frame_indices[state_.frame_indices.size() - 1 - pictures];
  }

  // Tracks of the current picture that reach `gap` pictures back, and nodes of the grid that
  // `ahead` follows; none on the windscreen.
  std::vector<TrackedPoint> Points(int gap, const GridLinks& ahead) const;
  // Nodes of the grid without such a track, or without support.
  std::vector<cv::Point2f> UnfollowedPlaces(int gap, cv::Size image) const;
  // Step 4; `model` may be of kind kNone.
  // `before`: the other frame of the pair, or null. `world`: the calibrated motion, or null.
  // `views`: further pictures; those without a frame are passed over.
  absl::StatusOr<EvidenceResult> Judge(const ExtractedFrame* before, const ExtractedFrame& frame,
                                       int gap, const MotionModel& model,
                                       const std::vector<TrackedPoint>& points,
                                       const TwoViewMotion* world, const Pinhole& camera,
                                       const std::vector<OtherView>& views);

  const OwnVehicleBlocks& own_vehicle() const { return accumulator_.state().own_vehicle; }

  EvidenceLabellerState state() const;
  absl::Status Restore(EvidenceLabellerState state);

 private:
  EvidenceLabeller(const FrameLabellerOptions& options, GridTracker grid, FeatureTracker features,
                   EvidenceAccumulator accumulator);

  std::vector<TrackedPoint> GridPoints(int gap, const GridLinks& ahead) const;
  absl::Status AdvanceGrid(cv::Size size, const FramePairs& pairs);
  absl::Status AdvanceFeatures(const ExtractedFrame& before, const ExtractedFrame& frame,
                               const FramePairs& pairs);

  int stride_pixels_;
  bool draws_own_vehicle_;
  cv::Mat1b ignored_, windscreen_;
  GridTracker grid_;
  FeatureTracker features_;
  EvidenceAccumulator accumulator_;
  std::vector<uint8_t> is_textured_;  // of the grid's nodes, this picture's
  EvidenceLabellerState state_;       // picture and frame_indices only
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_EVIDENCE_LABELLER_H_
