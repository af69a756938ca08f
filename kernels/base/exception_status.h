// Exceptions of the standard library and of other libraries as statuses, at the places where a
// piece of work as a whole fails: a stage of a pipeline, a command, a thread.
//
//   std::bad_alloc, std::length_error, and
//   any exception for insufficient memory     ResourceExhausted
//   std::system_error                         Unavailable: a thread or another system resource
//   any other                                 Internal, with its text
#ifndef EGOSIEVE_KERNELS_BASE_EXCEPTION_STATUS_H_
#define EGOSIEVE_KERNELS_BASE_EXCEPTION_STATUS_H_

#include <utility>

#include "absl/status/status.h"

namespace egosieve::kernels {

// Of the exception that is being handled: call it inside a catch block.
absl::Status CurrentExceptionStatus();

// Whether an error is the machine's (memory, threads, the device) and not the data's: another
// attempt may succeed, so that nothing may take its place in the results.
bool IsOfTheMachine(const absl::Status& status);

// body() returns a status or a value or status; an exception becomes that status.
template <typename Body>
auto CatchExceptions(Body&& body) -> decltype(std::forward<Body>(body)()) {
  try {
    return std::forward<Body>(body)();
  } catch (...) {
    return CurrentExceptionStatus();
  }
}

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_EXCEPTION_STATUS_H_
