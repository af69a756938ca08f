// What a run has shown, in five lines: what moved, how sure that is, what is doubtful, where the
// files are, what to do next.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// All five, each with its line break. Errors of the run folder.
absl::StatusOr<std::string> ClosingLines(const RunFolder& folder);

}  // namespace egosieve::tools
