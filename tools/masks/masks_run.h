// The run of `masks`: segments the input and refines its masks where these are missing, then
// writes them for the other program.
#ifndef EGOSIEVE_TOOLS_MASKS_MASKS_RUN_H_
#define EGOSIEVE_TOOLS_MASKS_MASKS_RUN_H_

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/masks/masks_flags.h"

namespace egosieve::tools {

// `flags` is resolved here and gets the run folder. Errors of usage, of the input and of the
// environment; where segment or refine fails, its exit code. Nothing is written before all
// checks that need no segmented input.
absl::StatusOr<ExitCode> RunMasks(MasksFlags& flags);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_MASKS_RUN_H_
