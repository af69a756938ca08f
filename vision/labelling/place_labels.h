// Fills in the places of a labelled frame and their probabilities from evidence along tracks
// (vision/evidence/fusion.h). Places outside of the picture and places without a probability are
// counted as discarded.
#ifndef EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_
#define EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_

#include <vector>

#include "vision/evidence/evidence_accumulator.h"
#include "vision/geometry/motion_model.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// evidence: one per point. Nodes of the flow grid in options.ignored are labelled static.
void LabelByEvidence(const ExtractedFrame& frame, const std::vector<TrackedPoint>& points,
                     const MotionModel& model, const EvidenceResult& evidence,
                     const FrameLabellerOptions& options, LabelledFrame& result);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PLACE_LABELS_H_
