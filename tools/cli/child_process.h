// Runs a program in a process of its own: if it crashes, nothing else does.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

// arguments: the program's path first. log_path: for both its outputs; empty: this process's.
// Returns the exit code, or 128 + the signal that ended the process. While it runs, `stop_requested`
// is asked several times per second; once it is true, the child gets SIGTERM and is waited for. It
// gets SIGTERM, too, if this process or the calling thread ends before it.
// Errors: Unavailable if it cannot be started, with the system's reason.
absl::StatusOr<int> RunChild(std::vector<std::string> arguments, const std::string& log_path,
                             const std::function<bool()>& stop_requested);

// The path of the running program.
absl::StatusOr<std::string> OwnProgram();

}  // namespace egosieve::tools
