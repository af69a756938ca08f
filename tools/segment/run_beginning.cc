#include "tools/segment/run_beginning.h"

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "kernels/base/status_macros.h"
#include "tools/cli/version.h"
#include "tools/segment/resume.h"

namespace egosieve::tools {
namespace {

bool HasAllFrames(const Schedule& schedule, const std::vector<FrameLine>& lines,
                  vision::FrameSource& source, std::string& warning) {
  const int64_t from = schedule.first_frame(), step = schedule.frame_step();
  const int64_t next = lines.empty() ? from : lines.back().index + step;
  return IsComplete(next, step, schedule.MakePipeline(1, from).end_frame, source, warning);
}

}  // namespace

absl::StatusOr<std::optional<RunFolder>> CreateUnlessResumed(const SegmentCall& call) {
  if (call.resume && RunFolder::Open(call.directory).ok()) return std::optional<RunFolder>();
  EGOSIEVE_ASSIGN_OR_RETURN(RunFolder folder, RunFolder::Create(call.directory, call.overwrite));
  return std::make_optional(std::move(folder));
}

RunDescription DescribeRun(const SegmentCall& call, const DriveInput& input,
                           const kernels::DeviceInfo& device) {
  RunDescription description;
  description.version = kVersion;
  description.flags = DescribeSettings(call.settings);
  call.camera.Describe(description.flags);
  description.device = DescribeDevice(device);
  description.seed = call.settings.segmenter.labeller.seed;
  description.input = input.description;
  description.grid = {input.width_pixels, input.height_pixels,
                      call.settings.segmenter.stride_pixels};
  description.started_utc = UtcNow();
  return description;
}

absl::StatusOr<DriveWriter> StartRun(const SegmentCall& call, const RunFolder& folder,
                                     const RunDescription& description) {
  EGOSIEVE_ASSIGN_OR_RETURN(DriveWriter writer,
                            DriveWriter::Start(folder, description, description.device));
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Write(call.directory));
  return writer;
}

absl::StatusOr<RunBeginning> ContinueRun(const SegmentCall& call, RunDescription description,
                                         vision::FrameSource& frames,
                                         vision::OnlineSegmenter& segmenter) {
  RunBeginning beginning;
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(call.directory));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription before, folder.ReadDescription());
  const std::string device = description.device;
  if (call.allow_other_device) description.device = before.device;
  EGOSIEVE_RETURN_IF_ERROR(
      CheckSameRun(before, description, before.device != device, call.directory));
  RemoveAbandonedFiles(folder);
  const int64_t from = call.settings.schedule.first_frame();
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ReadWholeLines(folder, before));
  if (before.ended == "done" &&
      HasAllFrames(call.settings.schedule, lines, frames, beginning.warning)) {
    beginning.counts.emplace(before);
    for (const FrameLine& line : lines) beginning.counts->Add(line);
    const int64_t end = lines.empty() ? from : lines.back().index + 1;
    EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, end));
    return beginning;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const ResumePoint point,
                            FindResumePoint(folder, from, std::move(lines)));
  EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, point.next_frame));
  if (!point.checkpoint.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<vision::Frame> recent,
                              ReadRecentFrames(frames, from, point.next_frame - 1,
                                               segmenter.options().labeller.HistoryFrames()));
    EGOSIEVE_RETURN_IF_ERROR(segmenter.Restore(point.checkpoint, recent));
  }
  description.started_utc = before.started_utc;
  description.seconds = before.seconds;
  beginning.first_frame = point.next_frame;
  EGOSIEVE_ASSIGN_OR_RETURN(beginning.writer,
                            DriveWriter::Continue(folder, description, point.lines, device));
  // A kill may have prevented writing it before.
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Write(call.directory));
  return beginning;
}

}  // namespace egosieve::tools
