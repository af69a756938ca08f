// Turns statuses and exceptions into the C interface's codes and the thread's last error.
#ifndef EGOSIEVE_TOOLS_EMBED_C_LAST_ERROR_H_
#define EGOSIEVE_TOOLS_EMBED_C_LAST_ERROR_H_

#include <exception>
#include <new>
#include <utility>

#include "absl/status/status.h"
#include "tools/embed/include/egosieve/types.h"

// Exported so that both libraries share one last error per thread; not part of the public
// interface.
extern "C" EGOSIEVE_API void egosieve_internal_set_last_error(const char* function,
                                                              const char* text);

namespace egosieve::embed {

// Abseil has no code for an invalid handle. The library uses this one only for that.
inline constexpr absl::StatusCode kInvalidHandle = absl::StatusCode::kUnauthenticated;

egosieve_status CodeOf(const absl::Status& status);

// Stores "function: message" for this thread and returns CodeOf(status).
egosieve_status Report(const char* function, const absl::Status& status) noexcept;

// Runs a call's body, which returns an absl::Status. Exceptions become codes, too.
template <typename Body>
egosieve_status Guard(const char* function, Body&& body) noexcept {
  try {
    const absl::Status status = std::forward<Body>(body)();
    return status.ok() ? EGOSIEVE_OK : Report(function, status);
  } catch (const std::bad_alloc&) {
    egosieve_internal_set_last_error(function, "memory ran out");
    return EGOSIEVE_OUT_OF_MEMORY;
  } catch (const std::exception& error) {
    egosieve_internal_set_last_error(function, error.what());
    return EGOSIEVE_INTERNAL;
  } catch (...) {
    egosieve_internal_set_last_error(function, "an unknown exception");
    return EGOSIEVE_INTERNAL;
  }
}

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_LAST_ERROR_H_
