// egosieve refine DIR: masks, numbers and tracks of movers (frame_products.h).
#ifndef EGOSIEVE_TOOLS_REFINE_REFINE_COMMAND_H_
#define EGOSIEVE_TOOLS_REFINE_REFINE_COMMAND_H_

#include <memory>

#include "absl/status/statusor.h"
#include "tools/cli/command.h"
#include "tools/refine/refine_flags.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeRefineCommand();

// Errors of usage, of the run folder, of the input and of the environment; Cancelled, with whole
// chunks so far.
absl::StatusOr<ExitCode> RunRefine(const RefineFlags& flags);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REFINE_REFINE_COMMAND_H_
