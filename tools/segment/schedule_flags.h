// Which frames of a drive are segmented and when, which of them get a map, and when the model is
// stored.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SCHEDULE_FLAGS_H_
#define EGOSIEVE_TOOLS_SEGMENT_SCHEDULE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "tools/cli/frame_range.h"
#include "vision/frame/frame_source.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

class ScheduleFlags {
 public:
  void AddFlags(CLI::App& app);
  absl::Status Validate() const;

  int64_t first_frame() const { return range_.from; }
  // Difference between the indices of successive segmented frames.
  int64_t frame_step() const { return skip_ + 1; }
  const vision::FrameSourceOptions& source() const { return source_; }

  // Adds the flags to RunDescription::flags.
  void Describe(std::map<std::string, std::string>& flags) const;

  vision::PipelineOptions MakePipeline(int threads, int64_t first_frame) const;

  // Whether a frame gets a map. If the function is null, every frame does.
  std::function<bool(int64_t index)> WantedMaps() const;
  // Whether some frames get no map.
  bool LeavesMaps() const { return every_ > 1; }

 private:
  int64_t checkpoint_every_ = 25;
  FrameRange range_;
  int64_t every_ = 1;
  int64_t skip_ = 0;
  int64_t max_frames_ = 0;
  vision::FrameSourceOptions source_;
};

// Frames that are still to come; -1 where unknown.
int64_t ExpectedFrames(const vision::FrameSource& source, const vision::PipelineOptions& pipeline);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SCHEDULE_FLAGS_H_
