// Runs a drive through the methods to compare with (vision/segmentation/methods), frame by frame.
#ifndef EGOSIEVE_TOOLS_SEGMENT_METHOD_RUN_H_
#define EGOSIEVE_TOOLS_SEGMENT_METHOD_RUN_H_

#include <functional>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"
#include "vision/segmentation/methods/method_segmenter.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

// `read` is the answered frame, or a damaged frame, which has no answers (null).
using AnsweredFrame =
    std::function<absl::Status(vision::FrameRead& read, vision::MethodAnswers* answers)>;

// Processes frames of the options' range, each with the segmenter's frames ahead, like
// vision::RunPipeline without overlap, checkpoints or steps.
absl::StatusOr<vision::PipelineSummary> AnswerFrames(vision::FrameSource& source,
                                                     vision::MethodSegmenter& segmenter,
                                                     const vision::PipelineOptions& options,
                                                     const std::function<bool()>& stop_requested,
                                                     const AnsweredFrame& on_frame);

// The same, for the sink of a pipeline. `segmenter` has one method.
absl::StatusOr<vision::PipelineSummary> RunMethod(vision::FrameSource& source,
                                                  vision::MethodSegmenter& segmenter,
                                                  const vision::PipelineOptions& options,
                                                  const std::function<bool()>& stop_requested,
                                                  const vision::SegmentedFrameSink& sink);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_METHOD_RUN_H_
