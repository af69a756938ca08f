// How a run of `segment` begins: in a new run folder, or where the run that --resume finds there
// stopped.
#ifndef EGOSIEVE_TOOLS_SEGMENT_RUN_BEGINNING_H_
#define EGOSIEVE_TOOLS_SEGMENT_RUN_BEGINNING_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "kernels/runtime/device.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/segment_call.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

struct RunBeginning {
  std::optional<DriveWriter> writer;  // absent: the run is done, see below
  int64_t first_frame = 0;
  std::optional<DriveWriter::Counts> counts;  // only of a run that is done
  std::string warning;                        // of the input's end
};

// A new run folder; absent if --resume finds a run. Errors of RunFolder::Create.
absl::StatusOr<std::optional<RunFolder>> CreateUnlessResumed(const SegmentCall& call);

// The run that the call makes, at its start.
RunDescription DescribeRun(const SegmentCall& call, const DriveInput& input,
                           const kernels::DeviceInfo& device);

// Begins the new run in `folder`.
absl::StatusOr<DriveWriter> StartRun(const SegmentCall& call, const RunFolder& folder,
                                     const RunDescription& description);

// Continues the run of --resume and restores the segmenter's state. FailedPrecondition if that run
// differs from `description`; errors of resume.h. Leaves the input at any frame.
absl::StatusOr<RunBeginning> ContinueRun(const SegmentCall& call, RunDescription description,
                                         vision::FrameSource& frames,
                                         vision::OnlineSegmenter& segmenter);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_RUN_BEGINNING_H_
