// The pictures near a labelled frame: the places of its points in them, and the camera's motion to
// them.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/pinhole.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/pair_motions.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Places and motions in the pictures ahead of a frame. `near` is not used if it is the same as
// `far`.
struct Outlook {
  GridLinks links;
  View near, far;

  const View& longest() const { return far.frame != nullptr ? far : near; }
  bool empty() const { return near.frame == nullptr && far.frame == nullptr; }
};

// ahead: pictures after the frame, in order. `near` is the next picture, `far` the last before the
// size changes that flow reaches (pair_motions.h), in which slow motion shows. Pictures that repeat the one before are skipped. Empty
// if the pictures show another scene or their motion is not trusted. moved: for the nodes of the
// frame's grid (mover_memory.h).
absl::StatusOr<Outlook> LookAhead(const ExtractedFrame& frame,
                                  const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead,
                                  const Pinhole& camera, absl::Span<const float> moved,
                                  PairMotions& motions);

// Whether enough of the places are static.
bool IsTrusted(const TwoViewMotion& motion);

// Records the motion of a pair with `pair_count` correspondences, and the outcome if it is not trusted.
// Returns whether it is.
bool RecordMotion(const TwoViewMotion& motion, const Pinhole& camera, int64_t pair_count,
                  LabelledFrame& result);

}  // namespace egosieve::vision
