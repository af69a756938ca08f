#include "tools/embed/c/last_error.h"

#include <string>

namespace egosieve::embed {

egosieve_status CodeOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return EGOSIEVE_OK;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
      return EGOSIEVE_INVALID_ARGUMENT;
    case kInvalidHandle:
      return EGOSIEVE_INVALID_HANDLE;
    case absl::StatusCode::kFailedPrecondition:
      return EGOSIEVE_FAILED_PRECONDITION;
    case absl::StatusCode::kNotFound:
      return EGOSIEVE_NOT_FOUND;
    case absl::StatusCode::kDataLoss:
      return EGOSIEVE_DATA_LOSS;
    case absl::StatusCode::kUnimplemented:
      return EGOSIEVE_UNIMPLEMENTED;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kDeadlineExceeded:
      return EGOSIEVE_UNAVAILABLE;
    case absl::StatusCode::kResourceExhausted:
      return EGOSIEVE_OUT_OF_MEMORY;
    case absl::StatusCode::kCancelled:
      return EGOSIEVE_CANCELLED;
    default:
      return EGOSIEVE_INTERNAL;
  }
}

egosieve_status Report(const char* function, const absl::Status& status) noexcept {
  try {
    egosieve_internal_set_last_error(function, std::string(status.message()).c_str());
  } catch (...) {
    egosieve_internal_set_last_error(function, "memory ran out while an error was described");
  }
  return CodeOf(status);
}

}  // namespace egosieve::embed
