// Which frames of a drive are segmented, and when the model is stored.
#pragma once

#include <cstdint>

#include "tools/cli/frame_range.h"
#include "vision/frame/frame_source.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

struct Schedule {
  FrameRange range;
  int64_t skip = 0;               // frames between two that are segmented
  int64_t max_frames = 0;         // 0: no limit
  int64_t checkpoint_every = 25;  // frames; 0: no checkpoints
  vision::FrameSourceOptions source;

  int64_t first_frame() const { return range.from; }
  // Difference between the indices of successive segmented frames.
  int64_t frame_step() const { return skip + 1; }

  vision::PipelineOptions MakePipeline(int threads, int64_t first_frame) const;
};

// Frames that are still to come; -1 where unknown.
int64_t ExpectedFrames(const vision::FrameSource& source, const vision::PipelineOptions& pipeline);

}  // namespace egosieve::tools
