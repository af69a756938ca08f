#include "tools/embed/c/call.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <new>
#include <string>

namespace egosieve::embed {
namespace {

egosieve_status CodeOf(absl::StatusCode code) {
  using enum absl::StatusCode;
  static constexpr std::pair<absl::StatusCode, egosieve_status> kCodes[] = {
      {kInvalidArgument, EGOSIEVE_INVALID_ARGUMENT},
      {kOutOfRange, EGOSIEVE_INVALID_ARGUMENT},
      {kInvalidHandle, EGOSIEVE_INVALID_HANDLE},
      {kFailedPrecondition, EGOSIEVE_FAILED_PRECONDITION},
      {kNotFound, EGOSIEVE_NOT_FOUND},
      {kDataLoss, EGOSIEVE_DATA_LOSS},
      {kUnimplemented, EGOSIEVE_UNIMPLEMENTED},
      {kUnavailable, EGOSIEVE_UNAVAILABLE},
      {kPermissionDenied, EGOSIEVE_UNAVAILABLE},
      {kDeadlineExceeded, EGOSIEVE_UNAVAILABLE},
      {kResourceExhausted, EGOSIEVE_OUT_OF_MEMORY},
      {kCancelled, EGOSIEVE_CANCELLED},
  };
  const auto* found = std::find_if(std::begin(kCodes), std::end(kCodes),
                                   [&](const auto& entry) { return entry.first == code; });
  return found == std::end(kCodes) ? EGOSIEVE_INTERNAL : found->second;
}

}  // namespace

egosieve_status ReportException(const char* function) noexcept {
  egosieve_status code = EGOSIEVE_INTERNAL;
  try {
    throw;
  } catch (const CallError& error) {
    code = CodeOf(error.status.code());
    try {
      egosieve_internal_set_last_error(function, std::string(error.status.message()).c_str());
    } catch (...) {
      egosieve_internal_set_last_error(function, "memory ran out while an error was described");
    }
  } catch (const std::bad_alloc&) {
    code = EGOSIEVE_OUT_OF_MEMORY;
    egosieve_internal_set_last_error(function, "memory ran out");
  } catch (const std::exception& error) {
    egosieve_internal_set_last_error(function, error.what());
  } catch (...) {
    egosieve_internal_set_last_error(function, "an unknown exception");
  }
  return code;
}

}  // namespace egosieve::embed
