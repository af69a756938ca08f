// The whole front end as one object: frames in, labelled places out.
//
//   1. grey, equalised picture                                   vision/frame/equalization.h
//   2. features of the frame, computed once                      vision/features
//   3. correspondences with the frame `frame_gap` before it,
//      searched where the motion before leads                    vision/matching, features
//   4. motion model of the camera, selected and fitted           vision/geometry
//   5. residual of each correspondence, and its probability of
//      belonging to something that moves                         vision/labelling/label_rule.h
//
// With evidence beyond the epipolar distance (evidence_terms.h) correspondences are those of the
// last two frames, chained into tracks, and the label is the fused probability:
// evidence_labeller.h.
//
// Step 2 needs nothing but the frame: Extract() is const and may run ahead on other threads, in any
// order. Label() does the rest and must see the frames in order.
//
// State, for resuming: what Label(t) returns depends on the frames t - frame_gap .. t, on those
// given as `ahead`, and on state(), about 3 MB carried from frame to frame (labeller_state.h). So
// after Restore(state() as it was after frame t) and Prime() with the frames t - frame_gap + 1 .. t
// in order, all later results have the same bytes as without the interruption. Random numbers are
// drawn from (seed, frame index).
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
#include "vision/labelling/labelled_frame.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

enum class FeatureSource {
  kSiftCorners,  // SIFT key points and Shi-Tomasi corners, matched by SIFT descriptors
  kFlow,         // a regular grid, tracked by dense inverse-search flow
  kBoth,         // both
  kAuto,         // the grid where the flow holds for most of it, else both
};

enum class LabelRule {
  kScaledDistance,  // p = d / paper_distance_pixels; matches further away are discarded as false
  kScaledMedian,    // p = min(1, d / (median_multiple max(floor, 1.48 median d))); none discarded
  kMixture,         // posterior of a static Gaussian against a dynamic uniform density
};

enum class LabelledSide { kFirstFrame, kCurrentFrame };

struct FrameLabellerOptions {
  FeatureSource features = FeatureSource::kAuto;
  // kCalibrated is kAuto where focal_ratio is not known or `evidence` is the epipolar distance
  // alone.
  MotionModelChoice motion_model = MotionModelChoice::kCalibrated;
  // Focal length over the image's longer side (drive_camera.h); 0: not known.
  double focal_ratio = 0.0;
  TravelPrior travel;  // the drive's, where it is known (drive_camera.h)
  LabelRule label_rule = LabelRule::kScaledMedian;  // read where `evidence` is epipolar alone
  EvidenceTerms evidence;                           // needs LabelledSide::kCurrentFrame else
  LabelledSide labelled_side = LabelledSide::kCurrentFrame;
  EqualizationOptions equalization;
  // ignored_area.h: no motion is estimated from there, and the labels there are static.
  cv::Mat1b ignored;
  // Matches there count for nothing: own_vehicle/windscreen.h.
  cv::Mat1b windscreen;
  // M of fixed_pattern.h, where it is known: what agrees with it is not taken for a mover because
  // the ground below it moves on.
  cv::Mat1b fixed_pattern;

  // Pictures are reduced to this longer side before anything is measured (reduced_labels.h); 0:
  // they are not. What is in pixels below is in pixels of the reduced pictures.
  int longest_side_pixels = 0;
  int frame_gap = 1;         // frames between the two of a pair; 1 to 100; 0: auto
  int feature_count = 0;     // SIFT and corners asked for; 0: 7000 at 1242 x 375, by area
  double match_ratio = 0.8;  // nearest to second-nearest descriptor distance; (0, 1]
  // Features are looked for where motion leads, and everywhere only where that is not known: else
  // always everywhere.
  bool windowed_search = true;
  bool drop_lone_matches = true;  // features that move like none near them are false matches
  int flow_stride_pixels = 5;     // of the flow grid; 1 to 100
  // kFast loses what is small and quick: cars that cross 30 m away.
  FlowQuality flow_quality = FlowQuality::kMedium;
  bool searches_lost = true;         // flow_growth.h: finds small cars that cross
  double paper_distance_pixels = 3;  // kScaledDistance: the furthest plausible distance; positive
  double median_multiple = 6;        // kScaledMedian; positive
  double noise_floor_pixels = 0.2;   // kScaledMedian, kMixture; positive
  double flow_noise_share = 0.03;    // k of label_rule.h (L0); not negative
  int minimum_matches = 30;          // fewer, and no label is given; at least 8
  uint64_t seed = 1;
  int threads = 2;  // 1 to 256

  // Faithful to the paper: SIFT and corners, fundamental matrix, scaled distance, first frame.
  static FrameLabellerOptions Paper();

  // The frames before the current one that Prime needs; with auto, those of the longest gap.
  int HistoryFrames() const { return frame_gap > 0 ? frame_gap : kLongestAutoGap; }
  static constexpr int kLongestAutoGap = 5;

  // Whether the motion is that of two_view_motion.h.
  bool IsCalibrated() const { return WantsCamera() && focal_ratio > 0.0; }
  // Whether it would be, were the focal length known.
  bool WantsCamera() const {
    return motion_model == MotionModelChoice::kCalibrated && !evidence.IsEpipolarAlone();
  }

  // InvalidArgument, naming field, value and rule.
  absl::Status Validate() const;
};

// What step 2 makes of a frame; shared and immutable.
struct ExtractedFrame;

class FrameLabeller {
 public:
  static absl::StatusOr<std::unique_ptr<FrameLabeller>> Create(const FrameLabellerOptions& options);
  ~FrameLabeller();

  // Label(Extract(frame)). An error means a frame that cannot be (not CV_8UC3, empty, an index that
  // does not grow); the state is unchanged then. Frames that cannot be learnt from are outcomes.
  absl::StatusOr<LabelledFrame> Process(const Frame& frame);

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  // `ahead`: what Extract made of the pictures after the frame, in order, as far as the caller
  // looks ahead; labels then rest on both sides.
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead = {});

  // Takes the frame into the history without labelling it.
  absl::Status Prime(const Frame& frame);

  // What is carried from frame to frame beside the frames themselves.
  // Bytes, equal for equal states (labeller_state.h).
  std::string state() const;
  // Sets it and empties the history. InvalidArgument for bytes that are no state() of this version.
  absl::Status Restore(absl::string_view state);

  const FrameLabellerOptions& options() const;

 private:
  class Implementation;
  explicit FrameLabeller(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FRAME_LABELLER_H_
