// Copies the results of a frame's labelling to its record.
#ifndef EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_
#define EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_

#include "vision/labelling/labelled_frame.h"
#include "vision/segmentation/frame_record.h"

namespace egosieve::vision {

// Writes the fields of `record` that come from labelling, including its times.
void RecordLabels(const LabelledFrame& labels, FrameRecord& record);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_
