// The whole front end as one object: frames in, labelled places out.
//
//   1. grey, equalised picture                                   vision/frame/equalization.h
//   2. features of the frame, computed once                      vision/features
//   3. correspondences with the frame `frame_gap` before it,
//      searched where the last motion predicts them              vision/matching, features
//   4. motion model of the camera, selected and fitted           vision/geometry
//   5. residual of each correspondence, and its probability of
//      belonging to a mover                                      vision/labelling/label_rule.h
//
// With evidence beyond the epipolar distance (evidence_terms.h), correspondences are those of the
// last two frames, chained into tracks, and the label is the fused probability:
// evidence_labeller.h.
//
// Steps 1 and 2 need only the frame: Extract() is const and may run ahead on other threads, in any
// order. Label() does the other steps and must be called for the frames in order.
//
// Resuming: the result of Label(t) depends on frame t, on the HistoryFrames() pictures before it,
// on the frames in `ahead`, and on state(), about 3 MB (labeller_state.h). After Restore(state()
// after frame t) and Prime() with the frames of the last HistoryFrames() pictures in order, all
// later results are byte for byte the same as without the interruption. Random numbers are drawn
// from (seed, frame index).
//
// Results do not depend on the number of threads.
#ifndef EGOSIEVE_VISION_LABELLING_FRAME_LABELLER_H_
#define EGOSIEVE_VISION_LABELLING_FRAME_LABELLER_H_

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/equalization.h"
#include "vision/frame/frame.h"
#include "vision/geometry/motion_model.h"
#include "vision/labelling/evidence_terms.h"
#include "vision/labelling/focal_learner.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

enum class FeatureSource {
  kSiftCorners,  // SIFT key points and Shi-Tomasi corners, matched by SIFT descriptors
  kFlow,         // a regular grid, tracked by dense inverse-search flow
  kBoth,         // both
  kAuto,         // the grid if enough of it can be tracked (kFlowSuffices), else both
};

enum class LabelRule {
  kScaledDistance,  // p = d / paper_distance_pixels; matches with larger d are discarded as false
  kScaledMedian,    // p = min(1, d / (median_multiple max(floor, 1.48 median d))); none discarded
  kMixture,         // posterior of a static Gaussian against a dynamic uniform density
};

enum class LabelledSide { kFirstFrame, kCurrentFrame };

struct FrameLabellerOptions {
  FeatureSource features = FeatureSource::kAuto;
  // kCalibrated acts as kAuto while the focal length is not known, and if `evidence` is the
  // epipolar distance alone.
  MotionModelChoice motion_model = MotionModelChoice::kCalibrated;
  // Focal length over the image's longer side (drive_camera.h); 0: not known.
  double focal_ratio = 0.0;
  // Whether a focal_ratio that is not known is learnt while frames are labelled (focal_learner.h),
  // for drives without a first pass.
  bool learns_focal_ratio = false;
  TravelPrior travel;  // the drive's direction of travel, if known (drive_camera.h)
  LabelRule label_rule = LabelRule::kScaledMedian;  // read only if `evidence` is epipolar alone
  EvidenceTerms evidence;  // all but epipolar alone needs LabelledSide::kCurrentFrame
  LabelledSide labelled_side = LabelledSide::kCurrentFrame;
  EqualizationOptions equalization;
  // ignored_area.h: not used for the camera's motion, and labelled static.
  cv::Mat1b ignored;
  // own_vehicle/windscreen.h: matches in it are not used.
  cv::Mat1b windscreen;
  // M of fixed_pattern.h, if known. Places that agree with it are not used for the camera's motion,
  // and are not labelled as moving because the ground below them moves. If known,
  // evidence.own_vehicle has no effect: the first pass, which knew it, found the own vehicle.
  cv::Mat1b fixed_pattern;

  // The longer side to which pictures are reduced before all measurements (reduced_labels.h); 0:
  // not reduced. The options in pixels below refer to the reduced pictures.
  int longest_side_pixels = 0;
  int frame_gap = 1;         // frames between the two of a pair; 1 to 100; 0: auto
  int feature_count = 0;     // target number of SIFT and corners; 0: 7000 at 1242 x 375, by area
  double match_ratio = 0.8;  // nearest to second-nearest descriptor distance; (0, 1]
  // true: features are searched for near their predicted places, and everywhere only if there is no
  // prediction or few are found; false: always everywhere.
  bool windowed_search = true;
  bool drop_lone_matches = true;  // discard matches that disagree with all their neighbours
  int flow_stride_pixels = 5;     // of the flow grid; 1 to 100
  // kFast loses small, fast objects.
  FlowQuality flow_quality = FlowQuality::kMedium;
  bool searches_lost = true;         // flow_growth.h: finds small cars that cross
  double paper_distance_pixels = 3;  // kScaledDistance: the greatest plausible distance; positive
  double median_multiple = 6;        // kScaledMedian; positive
  double noise_floor_pixels = 0.2;   // kScaledMedian, kMixture; positive
  double flow_noise_share = 0.03;    // k of label_rule.h (L0); not negative
  int minimum_matches = 30;          // with fewer, no labels are given; at least 8
  uint64_t seed = 1;
  int threads = 2;  // 1 to 256

  // As in the paper: SIFT and corners, fundamental matrix, scaled distance, first frame.
  static FrameLabellerOptions Paper();

  // Number of different pictures before the current one that Prime needs; with auto, of the longest
  // gap.
  int HistoryFrames() const { return frame_gap > 0 ? frame_gap : kLongestAutoGap; }
  static constexpr int kLongestAutoGap = 5;

  bool LearnsFocalRatio() const {
    return learns_focal_ratio && WantsCamera() && !(focal_ratio > 0.0);
  }
  // Whether the camera's motion is estimated by two_view_motion.h where the focal length is known.
  bool WantsCamera() const {
    return motion_model == MotionModelChoice::kCalibrated && !evidence.IsEpipolarAlone();
  }

  // InvalidArgument, naming field, value and rule.
  absl::Status Validate() const;
};

// Result of steps 1 and 2; shared and immutable.
struct ExtractedFrame;

class FrameLabeller {
 public:
  static absl::StatusOr<std::unique_ptr<FrameLabeller>> Create(const FrameLabellerOptions& options);
  ~FrameLabeller();

  // Label(Extract(frame)). An error means an invalid frame (not CV_8UC3, empty, an index that does
  // not grow); the state is unchanged then. A frame that cannot be labelled is not an error: see
  // LabelOutcome.
  absl::StatusOr<LabelledFrame> Process(const Frame& frame);

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  // Computes what labels need of two frames that follow each other and of nothing else: flow, and
  // the grid it tracks. Label does so itself, but later. const and thread-safe; may run beside
  // Label, not beside Restore.
  absl::Status Prepare(const ExtractedFrame& first, const ExtractedFrame& second) const;
  // ahead: results of Extract for pictures after the frame, in order; may be empty. Labels then use
  // the pictures before and after the frame.
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead = {});

  // Takes the frame into the history without labelling it.
  absl::Status Prime(const Frame& frame);

  // What learns_focal_ratio has given so far.
  LearntCamera learnt_camera() const;

  // The state carried from frame to frame, without the frames themselves, as bytes
  // (labeller_state.h). Equal states give equal bytes.
  std::string state() const;
  // Sets the state and empties the history. InvalidArgument for bytes that are no state() of this
  // version.
  absl::Status Restore(absl::string_view state);

  const FrameLabellerOptions& options() const;

 private:
  class Implementation;
  explicit FrameLabeller(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FRAME_LABELLER_H_
