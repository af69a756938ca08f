// The run of `infer`: the maps that are due and missing, made from the models that a run keeps.
#ifndef EGOSIEVE_TOOLS_INFER_INFER_RUN_H_
#define EGOSIEVE_TOOLS_INFER_INFER_RUN_H_

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/infer/infer_flags.h"

namespace egosieve::tools {

// Follows a run that segment is still writing, to its end. FailedPrecondition if the run keeps no
// models or the input is not its own; InvalidArgument for flags that do not fit the run; DataLoss;
// Cancelled, with whole maps so far.
absl::StatusOr<ExitCode> RunInfer(const InferFlags& flags);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_INFER_RUN_H_
