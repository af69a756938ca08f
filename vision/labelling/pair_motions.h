// Places of a picture's grid nodes in the pictures ahead, and the camera's motion between pictures.
//
// Flows between consecutive pictures are chained,
//
//   x_0 a node of the grid,  x_(k+1) = x_k + f_k(x_k)                                      (PM1)
//
// each step checked forward and backward as in flow_grid.h. The last place of a chain shows slow
// motion, the first one follows small, fast objects. A place that a mover occludes in the picture
// before is visible in a later one. Flows and motions are computed once and used twice: looking
// ahead from the first picture of a pair, and looking back from the second. Flows are not part of
// the state, because the same pictures give the same flows. Motions are, because they depend on the
// movers before the first picture.
//
// Of a hand-held camera, the last picture of a chain is the one up to which flow follows at least
// kFollowsFar of the textured places of the first step, or the first one: what flow has lost by
// then moves fast. Of a vehicle's camera it is the last one given, since what moves ahead of it is
// slow and shows there alone, while flow loses the road.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/flow_cache.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// As in tools/run_folder/baselines.h, where pairs of pictures that follow each other are judged.
inline constexpr double kFollowsFar = 0.7;

// Places of a picture that agree with the drive's fixed pattern
// (vision/own_vehicle/fixed_pattern.h): reflections, dirt on the windscreen, and parts of the own
// vehicle that were not found as such.
class PatternPlaces {
 public:
  PatternPlaces() = default;  // none
  // pattern: null if not known. grey: if it is not of the drive's size, no place agrees.
  PatternPlaces(const FixedPattern* pattern, const cv::Mat& grey);

  bool empty() const { return agreeing_.empty(); }
  // place: in `grey`, pixels.
  bool Contain(cv::Point2f place) const;

 private:
  cv::Mat1b agreeing_;  // of the reduced picture
  double scale_ = 1.0;  // reduced over given
};

// Places of a picture's grid nodes in two later pictures; NaN where flow failed. Empty if no
// pictures were given or they are too small for flow.
struct GridLinks {
  cv::Size nodes;                      // of the grid
  std::vector<cv::Point2f> near, far;  // one per node: in the next picture, and in the last one
  size_t last = 0;                     // which of the pictures given is the last one
  std::vector<uint8_t> is_textured;    // one per node
  double followed_share = 0.0;         // share of the textured nodes that `near` follows

  bool empty() const { return near.empty(); }
};

// The camera's motion between the pictures of two frames.
struct KnownMotion {
  int64_t first = -1, second = -1;  // indices of the frames
  TwoViewMotion motion;
};

class PairMotions {
 public:
  using Pictures = std::vector<const ExtractedFrame*>;  // of one size, in order

  // pattern: the drive's; null: not known.
  PairMotions(const FlowGridOptions& options, const TwoViewMotionOptions& motion_options,
              std::shared_ptr<const FixedPattern> pattern)
      : options_(options),
        motion_options_(motion_options),
        pattern_(std::move(pattern)),
        flows_(std::make_unique<FlowCache>(options)) {}

  FlowCache& flows() { return *flows_; }
  // Time spent on flows since the last call, or waiting for them.
  double TakeFlowMilliseconds() { return std::exchange(flow_milliseconds_, 0.0); }

  // The places of a picture that agree with the drive's fixed pattern. They are not used for the
  // camera's motion.
  const PatternPlaces& FixedIn(const ExtractedFrame& picture);

  // Follows the nodes of the first of at least two pictures; empty if they are too small for flow.
  absl::StatusOr<GridLinks> Follow(const Pictures& pictures);
  // The camera's motion from `first` to `last`, in which the nodes of `links` are at `places`. Only
  // textured nodes count; not found if too few are known. moved: nodes that moved before `first`
  // (mover_memory.h); empty: not known.
  TwoViewMotion Along(const ExtractedFrame& first, const ExtractedFrame& last,
                      const GridLinks& links, const std::vector<cv::Point2f>& places,
                      const Pinhole& camera, absl::Span<const float> moved);
  // The same between consecutive pictures.
  absl::StatusOr<TwoViewMotion> Between(const ExtractedFrame& first, const ExtractedFrame& second,
                                        const Pinhole& camera, absl::Span<const float> moved);
  // The motion between the two frames if it is known, else null.
  const TwoViewMotion* Find(int64_t first, int64_t second) const;
  // Exports the motions, and imports those of an earlier run.
  std::vector<KnownMotion> known() const;
  void Restore(const std::vector<KnownMotion>& known);
  // For the pairs to come; forgets all motions known.
  void SetMotionOptions(const TwoViewMotionOptions& options) {
    motion_options_ = options;
    motions_.clear();
  }
  // Drops the data of pictures and flows from before the frame `index`, and the motions that begin
  // before it, but for those between pictures from the frame `oldest` to `index`.
  void Forget(int64_t index, int64_t oldest);

 private:
  FlowGridOptions options_;
  TwoViewMotionOptions motion_options_;
  std::shared_ptr<const FixedPattern> pattern_;
  std::unique_ptr<FlowCache> flows_;
  double flow_milliseconds_ = 0.0;
  std::map<int64_t, PatternPlaces> fixed_;                        // by index
  std::map<std::pair<int64_t, int64_t>, TwoViewMotion> motions_;  // by first and last index
};

}  // namespace egosieve::vision
