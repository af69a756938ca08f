// The program's exit codes, and how a Status becomes one.
//
//   0    done
//   1    error of the environment: no device, a full disk, a folder that cannot be written
//   2    usage: a flag, a value or a folder that does not fit the command
//   3    the input cannot be read
//   4    finished, with some frames failed, or with a model that learnt from fewer than half of
//        them
//   130  interrupted; everything written so far is complete
#pragma once

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
// DataLoss are inputs that cannot be read; Cancelled is an interruption; all others are the
// environment.
ExitCode ExitCodeForStatus(const absl::Status& status);

// `status` as an error of the input, whatever its code: OK stays OK, any other becomes DataLoss
// with the same message.
absl::Status AsInputError(const absl::Status& status);
// The same as an error of usage: InvalidArgument.
absl::Status AsUsageError(const absl::Status& status);

// An error's one line for stderr: "egosieve: what; what to do". Line breaks become spaces.
std::string ErrorLine(absl::string_view message);

}  // namespace egosieve::tools
