// The places of a labelled frame with their probabilities, from the distance to the motion model
// (label_rule.h) or from evidence along tracks (vision/evidence/fusion.h). Places outside of the
// picture, and those that the rule or the evidence gives no probability, are counted as discarded.
#ifndef EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_
#define EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_

#include <vector>

#include "vision/evidence/evidence_accumulator.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/label_rule.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// `labelled` is the frame of the pair that options.labelled_side names. `mixture` goes from frame
// to frame.
void LabelByDistance(const ExtractedFrame& labelled, const std::vector<PointPair>& pairs,
                     const MotionModel& model, const FrameLabellerOptions& options,
                     MixtureState& mixture, LabelledFrame& result);

// evidence: one a point. The nodes of the flow grid that options.ignored covers are static.
void LabelByEvidence(const ExtractedFrame& frame, const std::vector<TrackedPoint>& points,
                     const MotionModel& model, const EvidenceResult& evidence,
                     const FrameLabellerOptions& options, LabelledFrame& result);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_
