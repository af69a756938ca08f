// The run of `segment`: reads the drive, segments it frame by frame into the run folder, and tells
// how it ended.
#pragma once

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/segment/segment_call.h"

namespace egosieve::tools {

// `call` has its flags; its camera is read and found here. Errors of usage (InvalidArgument,
// FailedPrecondition, AlreadyExists), of the input (DataLoss) and of the environment; Cancelled
// with whole frames so far. Nothing is written unless the flags fit and the input can be read.
absl::StatusOr<ExitCode> RunSegment(SegmentCall& call);

}  // namespace egosieve::tools
