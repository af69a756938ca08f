// The camera's step from the frame before.
#ifndef EGOSIEVE_VISION_LABELLING_FRAME_STEP_H_
#define EGOSIEVE_VISION_LABELLING_FRAME_STEP_H_

#include <cstdint>
#include <string>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/labelling/outlook.h"
#include "vision/trajectory/camera_step.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Motions of a frame to the pictures near it.
struct FrameViews {
  int64_t index_before = 0, index = 0;   // in the input: of the frame before and of this one
  int gap = 1;                           // frame gap of `world`
  const TwoViewMotion* world = nullptr;  // from the frame `gap` before; null: not trusted
  const View* behind = nullptr;          // to the frame before; read if `gap` is more than 1
  const Outlook* outlook = nullptr;
};

// The step is unknown without `world`, or if `behind` is needed and was not found.
CameraStep StepOf(const FrameViews& views, const std::vector<TrackedPoint>& points,
                  const Pinhole& camera);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FRAME_STEP_H_
