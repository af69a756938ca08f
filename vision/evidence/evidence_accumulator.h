// What two views and one line cannot tell, gathered along tracks: one probability of being dynamic
// for each point of a frame, and what it rests on.
//
//   1. pose between the frames t - g and t, where the motion model is a fundamental matrix;
//      relative_pose.h                                  absent where the camera did not travel
//   2. distance to the motion model: to the epipolar line of the pose, where the pose explains the
//      points as well as the given matrix does; else to the given model
//   3. sign of depth, negative_depth.h                  where 1 is there
//   4. three views t - 2g, t - g, t; three_view.h       where 1 is there, now and g frames ago
//   -  road, road_evidence.h                            where 1 is there and a plane has support
//   5. own vehicle, own_vehicle_blocks.h                where images are given; it has no part in
//                                                       the next frame's road
//   6. log-likelihood ratios, summed along the track, and their probability; fusion.h
//
// Residuals of 2 are divided by their robust scale, estimated from the frame and tracked over the
// drive (logarithm, forgetting `noise_memory`).
//
// State: sums of the tracks of the last frame, the poses of the last 2 g frames, scales, the share
// of movers, own vehicle. It is bounded by the points of one frame; an accumulator restored from it
// goes on bit for bit. Frame indices must grow; a frame left out loses the tracks that end with it
// and the pose, nothing else. Cost at 7000 points: about 6 ms a frame, without images.
#ifndef EGOSIEVE_VISION_EVIDENCE_EVIDENCE_ACCUMULATOR_H_
#define EGOSIEVE_VISION_EVIDENCE_EVIDENCE_ACCUMULATOR_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/evidence_options.h"
#include "vision/evidence/fusion.h"
#include "vision/evidence/guided_match.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"
#include "vision/evidence/three_view.h"
#include "vision/geometry/motion_model_kind.h"
#include "vision/own_vehicle/own_vehicle_blocks.h"
#include "vision/tracking/track.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// A point of frame t and where it was before, pixels; NaN where that is not known.
struct EvidencePoint {
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  int64_t track_id = -1;                    // -1: leaves no memory
  int64_t parent_id = -1;                   // its id in the last frame; -1: has no memory
  cv::Point2f now;                          // in frame t
  cv::Point2f before{kUnknown, kUnknown};   // in frame t - g
  cv::Point2f earlier{kUnknown, kUnknown};  // in frame t - 2 g
  bool estimates = true;                    // takes part in estimating motion, scales and shares
  bool is_fixed = false;  // may be fixed in the image: the ground's bound is no evidence

  bool HasBefore() const { return std::isfinite(before.x) && std::isfinite(before.y); }
};

EvidencePoint PointOfTrack(const Track& track, int gap);

// Another picture than those of the pair: what it says counts for the current frame and leaves no
// memory, for its pair is judged again when it is the current one.
struct EvidenceView {
  TwoViewMotion motion;             // from t to the picture
  cv::Mat grey;                     // CV_8UC1 of the frame's size
  std::vector<cv::Point2f> places;  // of the points in it, one a point; NaN where not known
  int pictures = 1;                 // from t to it; negative: it is before t; not 0
};

struct EvidenceFrame {
  int64_t index = 0;  // t
  int gap = 1;        // g, frames
  int pictures = 1;   // of the input from t - g to t, those left out included; as in `views`
  cv::Size size;      // of the image
  MotionModelKind motion_model = MotionModelKind::kNone;
  Eigen::Matrix3d motion_matrix = Eigen::Matrix3d::Identity();  // t - g to t, pixels
  // The calibrated motion t - g to t, where that was estimated; then the terms of the epipolar
  // distance and of negative depth are one, its log_moving - log_static.
  std::optional<TwoViewMotion> world;
  std::vector<EvidenceView> views;
  Pinhole camera;  // read where `world` or `views` are there
  std::vector<EvidencePoint> points;
  std::vector<cv::Point2f> unfollowed;  // places of frame t that flow does not follow; no points
  cv::Mat grey;         // CV_8UC1 of `size`, or empty: nothing is learnt about the own vehicle
  cv::Mat grey_before;  // of frame t - g, likewise; empty: places are taken at their word
};

struct PointEvidence {
  double probability = 0.5;
  // Of the current frame, by EvidenceTerm; not read where not present.
  std::array<double, kEvidenceTerms> log_ratio{};
  std::array<bool, kEvidenceTerms> present{};
  std::optional<double> views_log_ratio;              // of all `views`, a part of the epipolar term
  std::optional<double> views_road_log_ratio;         // of the longest view, a part of the road's
  bool judged = false;                                // anything known, now or from before
  EvidenceTerm decided_by = EvidenceTerm::kEpipolar;  // greatest part of L in its direction
  bool from_memory = false;  // the current frame alone would decide otherwise, or not at all
  bool own_vehicle = false;  // the rest is not read
};

struct EvidenceResult {
  std::vector<PointEvidence> points;  // one a point
  std::vector<GuidedPlace> standing;  // of `unfollowed`
  double standing_probability = 0.0;  // of being dynamic, of each of them
  PoseOutcome pose = PoseOutcome::kUndetermined;
  bool three_views = false;   // motion over three views found
  bool road = false;          // a road plane found
  bool pose_line = false;     // 2. used the pose's epipolar line
  double noise_pixels = 0.0;  // scale of 2.; 0 without
  double mover_share = 0.0;   // pi
};

struct EvidenceState {
  struct Memory {
    int64_t track_id = -1;
    std::array<double, kEvidenceTerms> sums{};  // A of (F3)
  };
  struct PastPose {
    int64_t index = -1;
    int gap = 0;
    RelativePose pose;
  };
  int64_t last_index = -1;
  cv::Size size;
  std::vector<Memory> memories;  // by increasing track_id
  std::vector<PastPose> poses;   // by increasing index
  double log_noise = 0.0;        // natural logarithm, pixels; of residuals of 2.
  bool has_noise = false;
  double mover_share = 0.1;
  RoadSlope road;
  OwnVehicleBlocks own_vehicle;
};

class EvidenceAccumulator {
 public:
  static absl::StatusOr<EvidenceAccumulator> Create(const EvidenceOptions& options);

  // InvalidArgument for an index that does not grow, a gap below 1, an empty size, an image that is
  // not grey or of another size, or a track id given twice; the state is unchanged then. A size
  // other than the last frame's starts anew.
  absl::StatusOr<EvidenceResult> Add(const EvidenceFrame& frame);

  // A cut: forgets tracks, poses, the road and the own vehicle's last images; keeps scales and
  // shares.
  void Interrupt();

  const EvidenceState& state() const { return state_; }
  // InvalidArgument for a state that is not whole.
  absl::Status Restore(EvidenceState state);

 private:
  explicit EvidenceAccumulator(const EvidenceOptions& options) : options_(options) {}

  struct Motion;
  Motion MotionOf(const EvidenceFrame& frame, EvidenceState& next) const;
  static std::vector<CalibratedPair> PairsOfViews(const EvidenceFrame& frame);
  // The epipolar term by calibrated_pairs.h; pictures: null where there are not both; views: those
  // of the frame as pairs.
  void MeasureCalibrated(const EvidenceFrame& frame, const PhotometricSupport* pictures,
                         const std::vector<CalibratedPair>& views, bool has_motion,
                         EvidenceResult& result) const;
  // The other terms of two and three views.
  void Measure(const EvidenceFrame& frame, const Motion& motion, const PhotometricSupport* pictures,
               EvidenceResult& result) const;
  // The road term of `result`; the plane need not be found.
  RoadPlane MeasureRoad(const EvidenceFrame& frame, const Motion& motion,
                        const PhotometricSupport* pictures, EvidenceState& next,
                        EvidenceResult& result) const;
  // The same from the longest of `views`: its depths are the surest.
  void MeasureRoadAhead(const EvidenceFrame& frame, const std::vector<CalibratedPair>& views,
                        const EvidenceState& next, EvidenceResult& result) const;
  void Fuse(const EvidenceFrame& frame, EvidenceState& next, EvidenceResult& result) const;

  EvidenceOptions options_;
  EvidenceState state_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_EVIDENCE_ACCUMULATOR_H_
