#include "tools/segment/schedule_flags.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

void ScheduleFlags::AddFlags(CLI::App& app) {
  app.add_option("--checkpoint_every", checkpoint_every_,
                 "Frames between checkpoints, from which --resume continues; 0: none")
      ->check(AtLeast<int64_t>(0))
      ->type_name("FRAMES");
  range_.AddFlags(app);
  app.add_option("--every", every_,
                 "Makes the map of each N-th frame only, from the first on; the frames between are "
                 "learnt from, too")
      ->check(AtLeast<int64_t>(1))
      ->type_name("N");
  app.add_option("--skip", skip_,
                 "Skips N frames between two that are segmented: they are neither learnt from nor "
                 "mapped")
      ->check(AtLeast<int64_t>(0))
      ->type_name("N");
  app.add_option("--fps", source_.nominal_rate_hz,
                 "Frames per second of a folder of images: sets their times, skips none")
      ->check(AtLeast(1e-3))
      ->capture_default_str();
  app.add_option("--times", source_.times,
                 "The times of the images of a folder or a glob, one per line")
      ->type_name("FILE");
  app.add_option("--max_frames", max_frames_, "Frames to segment at most; 0: no limit")
      ->check(AtLeast<int64_t>(0))
      ->type_name("FRAMES");
}

void ScheduleFlags::Describe(std::map<std::string, std::string>& flags) const {
  flags["from"] = absl::StrCat(range_.from);
  flags["checkpoint_every"] = absl::StrCat(checkpoint_every_);
  flags["every"] = absl::StrCat(every_);
  if (source_.nominal_rate_hz != vision::FrameSourceOptions().nominal_rate_hz) {
    flags["fps"] = absl::StrCat(source_.nominal_rate_hz);
  }
  if (!source_.times.empty()) flags["times"] = AbsolutePath(source_.times);
  if (skip_ > 0) flags["skip"] = absl::StrCat(skip_);
}

vision::PipelineOptions ScheduleFlags::MakePipeline(int threads, int64_t first_frame) const {
  vision::PipelineOptions pipeline;
  pipeline.overlap = threads > 1;
  pipeline.first_frame = first_frame;
  pipeline.frame_step = frame_step();
  pipeline.checkpoint_interval = checkpoint_every_;
  pipeline.wants_map = WantedMaps();
  pipeline.end_frame = range_.to >= 0 ? range_.to + 1 : -1;
  if (max_frames_ > 0) {
    const int64_t end = range_.from + max_frames_ * frame_step();
    pipeline.end_frame = pipeline.end_frame < 0 ? end : std::min(pipeline.end_frame, end);
  }
  return pipeline;
}

absl::Status ScheduleFlags::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(range_.Validate());
  if (skip_ > 0 && LeavesMaps()) {
    return absl::InvalidArgumentError(
        "--skip leaves out frames, --every only their maps; choose one of them");
  }
  return absl::OkStatus();
}

std::function<bool(int64_t)> ScheduleFlags::WantedMaps() const {
  if (every_ == 1) return nullptr;
  return
      [from = range_.from, every = every_](int64_t index) { return (index - from) % every == 0; };
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
