// The run of `segment`: reads the drive, segments it frame by frame into the run folder, and tells
// how it ended.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SEGMENT_RUN_H_
#define EGOSIEVE_TOOLS_SEGMENT_SEGMENT_RUN_H_

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/segment/segment_call.h"

namespace egosieve::tools {

// `call` has its flags; its camera is read and found here. Errors of usage (InvalidArgument,
// FailedPrecondition, AlreadyExists), of the input (DataLoss) and of the environment; Cancelled
// with whole frames so far. Nothing is written unless the flags fit and the input can be read.
absl::StatusOr<ExitCode> RunSegment(SegmentCall& call);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SEGMENT_RUN_H_
