#include "tools/segment/schedule.h"

#include <algorithm>

namespace egosieve::tools {

vision::PipelineOptions Schedule::MakePipeline(int threads, int64_t first_frame) const {
  vision::PipelineOptions pipeline;
  pipeline.overlap = threads > 1;
  pipeline.first_frame = first_frame;
  pipeline.frame_step = frame_step();
  pipeline.checkpoint_interval = checkpoint_every;
  pipeline.end_frame = range.to >= 0 ? range.to + 1 : -1;
  if (max_frames > 0) {
    const int64_t end = range.from + max_frames * frame_step();
    pipeline.end_frame = pipeline.end_frame < 0 ? end : std::min(pipeline.end_frame, end);
  }
  return pipeline;
}

int64_t ExpectedFrames(const vision::FrameSource& source, const vision::PipelineOptions& pipeline) {
  int64_t end = source.expected_frame_count();
  if (pipeline.end_frame >= 0) {
    end = end < 0 ? pipeline.end_frame : std::min(end, pipeline.end_frame);
  }
  if (end < 0) return -1;
  const int64_t frames = std::max<int64_t>(end - pipeline.first_frame, 0);
  return (frames + pipeline.frame_step - 1) / pipeline.frame_step;
}

}  // namespace egosieve::tools
