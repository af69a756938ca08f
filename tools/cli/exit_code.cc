#include "tools/cli/exit_code.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"

namespace egosieve::tools {

ExitCode ExitCodeForStatus(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return ExitCode::kDone;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kOutOfRange:
      return ExitCode::kUsage;
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kDataLoss:
      return ExitCode::kInputUnreadable;
    case absl::StatusCode::kCancelled:
      return ExitCode::kInterrupted;
    default:
      return ExitCode::kEnvironment;
  }
}

absl::Status AsInputError(const absl::Status& status) {
  return status.ok() ? status : absl::DataLossError(status.message());
}

absl::Status AsUsageError(const absl::Status& status) {
  return status.ok() ? status : absl::InvalidArgumentError(status.message());
}

std::string ErrorLine(absl::string_view message) {
  return absl::StrCat(
      "egosieve: ",
      absl::StrJoin(absl::StrSplit(message, absl::ByAnyChar("\r\n"), absl::SkipWhitespace()), " "));
}

}  // namespace egosieve::tools
