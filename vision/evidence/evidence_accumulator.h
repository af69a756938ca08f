// Evidence from several views, accumulated along tracks: for each point of a frame the probability
// of being dynamic, and the terms that it comes from.
//
//   1. moving against static under the camera's motions; calibrated_pairs.h
//   2. road: below it, or at another depth than the contact with it; road_contact.h
//                                                       needs parallax and a plane with support
//   3. log-likelihood ratios, summed along the track, and their probability; fusion.h
//
// State: sums of the tracks of the last frame, the share of movers, the road. Its size is bounded
// by the points of one frame. A restored accumulator gives the same results bit for bit. Frame
// indices must grow. A skipped frame loses only the tracks that end at it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/fusion.h"
#include "vision/evidence/guided_match.h"
#include "vision/geometry/pinhole.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// A point of frame t and its earlier positions, pixels; NaN where not known.
struct EvidencePoint {
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  int64_t track_id = -1;                   // -1: its evidence is not kept for the next frame
  int64_t parent_id = -1;                  // its id in the last frame; -1: no earlier evidence
  cv::Point2f now;                         // in frame t
  cv::Point2f before{kUnknown, kUnknown};  // in frame t - g
  bool estimates = true;                   // takes part in estimating the noise of grey levels
  // No ground bound and no road term: its depth is not known, for flow does not measure its motion
  // along the epipolar line, or the point may be fixed in the image.
  bool is_unbounded = false;

  bool HasBefore() const { return std::isfinite(before.x) && std::isfinite(before.y); }
};

// A picture other than the two of the pair. Its evidence counts for the current frame only and is
// not accumulated, because the same pair is evaluated again when that picture is the current one.
struct EvidenceView {
  TwoViewMotion motion;             // from t to the picture
  cv::Mat grey;                     // CV_8UC1 of the frame's size
  std::vector<cv::Point2f> places;  // of the points in it, one per point; NaN where not known
  int pictures = 1;                 // from t to it; negative: it is before t; not 0
};

struct EvidenceFrame {
  int64_t index = 0;  // t
  int pictures = 1;   // of the input from t - g to t, skipped ones included; as in `views`
  cv::Size size;      // of the image
  std::optional<TwoViewMotion> world;  // t - g to t, if known
  std::vector<EvidenceView> views;
  Pinhole camera;  // read if `world` is set or `views` is not empty
  std::vector<EvidencePoint> points;
  std::vector<cv::Point2f> unfollowed;  // places of frame t where flow failed; not in `points`
  // Of t and of t - g, CV_8UC1 of `size`; empty: grey levels do not limit the evidence.
  cv::Mat grey, grey_before;
};

struct PointEvidence {
  double probability = 0.5;
  // Log-likelihood ratios of the current frame, by EvidenceTerm: of the pair, and of `views`, all of
  // them or, of the road, the longest.
  std::array<std::optional<double>, kEvidenceTerms> of_pair, of_views;
  bool judged = false;  // has evidence, from this frame or earlier ones
  EvidenceTerm decided_by = EvidenceTerm::kEpipolar;  // greatest part of L in its direction
};

struct EvidenceResult {
  std::vector<PointEvidence> points;  // one per point
  std::vector<GuidedPlace> standing;  // those of `unfollowed` that are static road
  double standing_probability = 0.0;  // of being dynamic, for each place of `standing`
  double mover_share = 0.0;           // pi
};

struct EvidenceState {
  struct Memory {
    int64_t track_id = -1;
    std::array<double, kEvidenceTerms> sums{};  // A of (F2)
  };
  int64_t last_index = -1;
  cv::Size size;
  std::vector<Memory> memories;  // by increasing track_id
  double mover_share = 0.1;
};

class EvidenceAccumulator {
 public:
  // Each track id may be given once. A size other than the last frame's resets the state.
  EvidenceResult Add(const EvidenceFrame& frame);

  // For a cut in the video: drops tracks; keeps the share of movers.
  void Interrupt();

  const EvidenceState& state() const { return state_; }
  // InvalidArgument for an inconsistent state.
  absl::Status Restore(EvidenceState state);

 private:
  EvidenceState state_;
};

}  // namespace egosieve::vision
