// The whole front end as one object: frames in, labelled places out.
//
// The main implementation, track_labeller.h, fuses evidence along tracks. The front end of the
// paper, vision/paper/paper_labeller.h, takes distances to the epipolar lines of one pair.
// MakeFrameLabeller (vision/segmentation/labeller_factory.h) makes the one that the options name.
//
// Extract() needs only the frame: it is const and may run ahead on other threads, in any order.
// Label() must be called for the frames in order.
//
// Resuming: the result of Label(t) depends on frame t, on the HistoryFrames() pictures before it,
// on the frames in `ahead`, and on state(), about 3 MB (labeller_state.h). After Restore(state()
// after frame t) and Prime() with the frames of the last HistoryFrames() pictures in order, all
// later results are byte for byte the same as without the interruption. Random numbers are drawn
// from (seed, frame index).
//
// Results do not depend on the number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/equalization.h"
#include "vision/frame/frame.h"
#include "vision/geometry/lens_correction.h"
#include "vision/labelling/focal_learner.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

struct FrameLabellerOptions {
  bool is_paper = false;  // the paper's front end
  // Focal length over the image's longer side (drive_camera.h); 0: not known, and learnt while
  // frames are labelled (focal_learner.h), for drives without a first pass.
  double focal_ratio = 0.0;
  // Not null: pictures of its size are corrected before all measurements, and focal_ratio is that of
  // the pinhole pictures. `windscreen` and `fixed_pattern` are of these, and the pair's motion is
  // between them.
  std::shared_ptr<const LensCorrection> lens;
  TravelPrior travel;  // the drive's direction of travel, if known (drive_camera.h)
  Equalization equalization = Equalization::kNone;
  // ignored_area.h: not used for the camera's motion, and labelled static.
  cv::Mat1b ignored;
  // own_vehicle/windscreen.h: matches in it are not used.
  cv::Mat1b windscreen;
  // M of fixed_pattern.h, if known. On a vehicle, places that agree with it are not used for the
  // camera's motion, and are not labelled as moving.
  cv::Mat1b fixed_pattern;

  // The first frame of these options' shot, and the options of all later shots (shots.h), in order,
  // if this is the first.
  int64_t first_frame = 0;
  std::vector<FrameLabellerOptions> later_shots;

  // The longer side to which pictures are reduced before all measurements (reduced_labels.h); 0:
  // not reduced. The options in pixels below refer to the reduced pictures.
  int longest_side_pixels = 0;
  // Frames between the two of a pair; 1 to 100; 0: auto, not with the paper's front end.
  int frame_gap = 1;
  // kFast loses small, fast objects.
  FlowQuality flow_quality = FlowQuality::kMedium;
  bool searches_lost = true;  // flow_growth.h: finds small cars that cross
  uint64_t seed = 1;

  // As in the paper.
  static FrameLabellerOptions Paper();

  // Number of different pictures before the current one that Prime needs; with auto, of the longest
  // gap.
  int HistoryFrames() const { return frame_gap > 0 ? frame_gap : kLongestAutoGap; }
  static constexpr int kLongestAutoGap = 5;
  static constexpr int kFlowStridePixels = 5;  // of the flow grid
  static constexpr int kFewestMatches = 30;    // with fewer, no labels are given

  bool LearnsFocalRatio() const { return WantsCamera() && !(focal_ratio > 0.0); }
  // Whether the camera's motion is estimated by two_view_motion.h.
  bool WantsCamera() const { return !is_paper; }

  // InvalidArgument, naming field, value and rule.
  absl::Status Validate() const;
};

// What is computed once from a single frame. Shared by pointer and immutable to its users. A labeller
// may derive what else it needs.
struct ExtractedFrame {
  Frame frame;
  cv::Mat grey;  // CV_8UC1, equalised
  double equalization_milliseconds = 0.0;
};

class FrameLabeller {
 public:
  virtual ~FrameLabeller() = default;

  // Label(Extract(frame)). An error means an invalid frame (not CV_8UC3, empty, an index that does
  // not grow); the state is unchanged then. A frame that cannot be labelled is not an error: see
  // LabelOutcome.
  absl::StatusOr<LabelledFrame> Process(const Frame& frame);

  virtual absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(
      const Frame& frame) const = 0;
  // Computes what labels need of two frames that follow each other and of nothing else: flow, and
  // the grid it tracks. Label does so itself, but later. const and thread-safe; may run beside
  // Label, not beside Restore.
  virtual absl::Status Prepare(const ExtractedFrame& first, const ExtractedFrame& second) const = 0;
  // ahead: results of Extract for pictures after the frame, in order; may be empty. Labels then use
  // the pictures before and after the frame.
  virtual absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) = 0;
  absl::StatusOr<LabelledFrame> Label(std::shared_ptr<const ExtractedFrame> frame) {
    return Label(std::move(frame), {});
  }

  // Takes the frame into the history without labelling it.
  virtual absl::Status Prime(const Frame& frame) = 0;

  // What was learnt so far, where the focal length was not known.
  virtual LearntCamera learnt_camera() const = 0;

  // The state carried from frame to frame, without the frames themselves, as bytes. Equal states
  // give equal bytes.
  virtual std::string state() const = 0;
  // Sets the state and empties the history. InvalidArgument for bytes that are no state() of this
  // version.
  virtual absl::Status Restore(absl::string_view state) = 0;

  virtual const FrameLabellerOptions& options() const = 0;
};

}  // namespace egosieve::vision
