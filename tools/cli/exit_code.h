// What a program's exit code says, and how a Status becomes one.
//
//   0    done
//   1    the machine is in the way: no device, a full disk, a folder that cannot be written
//   2    usage: a flag, a value or a folder that does not fit the command
//   3    the input cannot be read
//   4    finished, with some frames failed
//   130  interrupted; what was written is whole
#ifndef EGOSIEVE_TOOLS_CLI_EXIT_CODE_H_
#define EGOSIEVE_TOOLS_CLI_EXIT_CODE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

enum class ExitCode {
  kDone = 0,
  kEnvironment = 1,
  kUsage = 2,
  kInputUnreadable = 3,
  kFramesFailed = 4,
  kInterrupted = 130,
};

// InvalidArgument, FailedPrecondition, AlreadyExists and OutOfRange are usage; NotFound and
// DataLoss are inputs that cannot be read; Cancelled is an interruption; all else is environment.
ExitCode ExitCodeForStatus(const absl::Status& status);

// `status` as an error of the input, whatever code the library below gave it: OK stays OK, all else
// becomes DataLoss with the same message.
absl::Status AsInputError(const absl::Status& status);
// Likewise for what the user asked for: InvalidArgument.
absl::Status AsUsageError(const absl::Status& status);

// An error's one line for stderr: "egosieve: what; what to do". Line breaks become spaces.
std::string ErrorLine(absl::string_view message);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_EXIT_CODE_H_
