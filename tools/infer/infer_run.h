// The run of `infer`: the maps that are due and missing, made from the models that a run keeps.
#ifndef EGOSIEVE_TOOLS_INFER_INFER_RUN_H_
#define EGOSIEVE_TOOLS_INFER_INFER_RUN_H_

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/infer/infer_flags.h"

namespace egosieve::tools {

// FailedPrecondition if the run keeps no models, the input is not its own, or another program works
// on the folder; InvalidArgument for flags that do not fit the run; DataLoss; Cancelled, with whole
// maps so far.
absl::StatusOr<ExitCode> RunInfer(const InferFlags& flags);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_INFER_RUN_H_
