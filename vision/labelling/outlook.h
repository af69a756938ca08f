// The pictures near a labelled one: where its places are in them, and the camera's motion to them.
#ifndef EGOSIEVE_VISION_LABELLING_OUTLOOK_H_
#define EGOSIEVE_VISION_LABELLING_OUTLOOK_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/evidence/pinhole.h"
#include "vision/geometry/motion_model.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/pair_motions.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Another picture, and the camera's motion from the labelled one to it; no frame: not to be used.
struct View {
  const ExtractedFrame* frame = nullptr;
  TwoViewMotion motion;
};

// What the pictures ahead say of a frame; `near` is not used where it is the same as `far`.
struct Outlook {
  GridLinks links;
  View near, far;

  const View& longest() const { return far.frame != nullptr ? far : near; }
  bool knows_ground() const {
    return near.motion.ground_slope > 0.0 || far.motion.ground_slope > 0.0;
  }
  bool empty() const { return near.frame == nullptr && far.frame == nullptr; }
};

// `ahead`: pictures after the frame, in order; `far` is the last before the size changes: what
// moves slowly shows over time. A picture that repeats the one before it is passed over. Empty
// where the pictures are of another scene or their motion is not to be trusted. moved: which nodes of
// the frame's grid moved before (mover_memory.h).
absl::StatusOr<Outlook> LookAhead(const ExtractedFrame& frame,
                                  const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead,
                                  const Pinhole& camera, absl::Span<const float> moved,
                                  PairMotions& motions);

// From `frame` to `before`, the picture before it; moved: of the grid of `before`.
absl::StatusOr<View> LookBack(const ExtractedFrame& before, const ExtractedFrame& frame,
                              const Pinhole& camera, absl::Span<const float> moved,
                              PairMotions& motions);

// The motion as the model of a pair, of `pair_count` pairs; not trusted where too few places agree.
MotionModel ModelOf(const TwoViewMotion& motion, const Pinhole& camera, int64_t pair_count);

// Whether two pictures are the same in every pixel.
bool SamePixels(const cv::Mat& a, const cv::Mat& b);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_OUTLOOK_H_
