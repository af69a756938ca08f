// What a frame's labels say of it.
#ifndef EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_
#define EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_

#include "vision/labelling/labelled_frame.h"
#include "vision/segmentation/frame_record.h"

namespace egosieve::vision {

// Writes the fields of `record` that come from labelling, its times included.
void RecordLabels(const LabelledFrame& labels, FrameRecord& record);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_LABEL_RECORD_H_
