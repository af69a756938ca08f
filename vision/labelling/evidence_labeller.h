// Labels from evidence accumulated along tracks.
//
//   1. links between the last two frames extend the tracks         vision/tracking
//   2. the other frame of the pair: g pictures ago, by the track   frame_labeller.h
//   3. the camera's motion between the two, from the tracks        vision/geometry
//   4. evidence and its probability                                vision/evidence
//
// Pictures are counted, not frame numbers: a repeated picture is not a step, and missing frames
// make the step longer. Without links for a picture the tracks end.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/geometry/pinhole.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/pair_motions.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {

struct EvidenceLabellerState {
  int64_t picture = -1;                // number of the last picture; -1: none
  std::vector<int64_t> frame_indices;  // of the pictures that tracks may reach, oldest first
  GridTrackerState grid;
  EvidenceState evidence;
};

inline const cv::Point2f kUnknownPlace{EvidencePoint::kUnknown, EvidencePoint::kUnknown};

// A point of the current picture, followed by a track or by flow to a picture ahead.
struct TrackedPoint {
  EvidencePoint evidence;
  // Its places in pictures other than the two of the pair; NaN where not followed or not used.
  cv::Point2f far_ahead = kUnknownPlace, near_ahead = kUnknownPlace, near_behind = kUnknownPlace;
  bool is_textured = true;
  bool is_supported = true;  // enough places around it could be followed as well
};

// Another picture, the camera's motion from the current one to it, and the points' places in it.
// Without a frame: not used.
struct View {
  const ExtractedFrame* frame = nullptr;
  TwoViewMotion motion;
  cv::Point2f TrackedPoint::*place = nullptr;
};

class EvidenceLabeller {
 public:
  explicit EvidenceLabeller(const FrameLabellerOptions& options);

  // For a picture without links from the one before: the first of the drive or after a cut.
  void Begin(int64_t frame_index);
  // For a frame that repeats the last picture.
  void Repeat(int64_t frame_index) { state_.frame_indices.back() = frame_index; }
  // Step 1. grid: the nodes of `frame`, tracked from the last picture.
  void Advance(const ExtractedFrame& frame, const TrackedGrid& grid);

  // Frame index of the last picture; -1: none.
  int64_t last_frame_index() const {
    return state_.frame_indices.empty() ? -1 : state_.frame_indices.back();
  }
  // Number of pictures that a track may reach back.
  int PicturesBefore() const { return static_cast<int>(state_.frame_indices.size()) - 1; }
  int64_t FrameIndexBefore(int pictures) const {
    return state_.frame_indices[state_.frame_indices.size() - 1 - pictures];
  }

  // Tracks of the current picture that reach `gap` pictures back, and nodes of the grid that
  // `ahead` follows; without those on the windscreen.
  std::vector<TrackedPoint> Points(int gap, const GridLinks& ahead) const;
  // Nodes of the grid without such a track or without support, outside of the ignored area.
  std::vector<cv::Point2f> UnfollowedPlaces(int gap, cv::Size image) const;
  // Step 4. `before`: the other frame of the pair, or null. `world`: the pair's motion, or null.
  // `views`: further pictures.
  EvidenceResult Judge(const ExtractedFrame* before, const ExtractedFrame& frame, int gap,
                       const std::vector<TrackedPoint>& points, const TwoViewMotion* world,
                       const Pinhole& camera, std::initializer_list<const View*> views);

  EvidenceLabellerState state() const;
  absl::Status Restore(EvidenceLabellerState state);

 private:
  void AdvanceGrid(cv::Size size, const TrackedGrid& grid);

  cv::Mat1b ignored_, windscreen_;
  GridTracker grid_;
  EvidenceAccumulator accumulator_;
  std::vector<uint8_t> is_textured_;  // of the grid's nodes in the current picture
  EvidenceLabellerState state_;       // picture and frame_indices only
};

}  // namespace egosieve::vision
