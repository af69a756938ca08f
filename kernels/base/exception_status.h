// Converts exceptions of the standard library and of other libraries to statuses. Used where a unit
// of work fails as a whole: a stage of a pipeline, a command, a thread.
//
//   std::bad_alloc, std::length_error, and
//   any exception for insufficient memory     ResourceExhausted
//   std::system_error, and
//   any exception for a thread not started    Unavailable: a thread or another system resource
//   any other                                 Internal, with its text
#pragma once

#include <utility>

#include "absl/status/status.h"

namespace egosieve::kernels {

// Status of the exception that is being handled; call it inside a catch block.
absl::Status CurrentExceptionStatus();

// Whether an error comes from the computer (memory, threads, the device) and not from the data.
// Another attempt may then succeed, so nothing may be substituted for the missing result.
bool IsOfTheMachine(const absl::Status& status);

// Calls body(), which returns a status or a StatusOr; an exception becomes such a status.
template <typename Body>
auto CatchExceptions(Body&& body) -> decltype(std::forward<Body>(body)()) {
  try {
    return std::forward<Body>(body)();
  } catch (...) {
    return CurrentExceptionStatus();
  }
}

}  // namespace egosieve::kernels
