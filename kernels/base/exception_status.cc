#include "kernels/base/exception_status.h"

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace egosieve::kernels {
namespace {

constexpr char kOutOfMemory[] =
    "out of memory; give the process more (see ulimit -v), smaller images, a smaller --budget or a "
    "larger --stride";
constexpr char kNoThread[] = "; allow more threads (see ulimit -u), or use --threads=1";

// Some libraries throw their own types where standard types exist.
bool IsAboutMemory(const std::string& text) {
  return absl::StrContains(text, "Insufficient memory") ||  // OpenCV
         absl::StrContains(text, "Cannot allocate memory");
}
bool IsAboutThreads(const std::string& text) {
  return absl::StrContains(text, "pthread_create");  // TBB
}

}  // namespace

bool IsOfTheMachine(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
}

absl::Status CurrentExceptionStatus() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(kOutOfMemory);
  } catch (const std::length_error&) {
    return absl::ResourceExhaustedError(kOutOfMemory);
  } catch (const std::system_error& error) {
    return absl::UnavailableError(
        absl::StrCat("the system refuses a thread or another resource: ", error.what(), kNoThread));
  } catch (const std::exception& error) {
    const std::string text = error.what();
    if (IsAboutMemory(text)) return absl::ResourceExhaustedError(kOutOfMemory);
    if (IsAboutThreads(text)) {
      return absl::UnavailableError(absl::StrCat("cannot start a thread: ", text, kNoThread));
    }
    return absl::InternalError(absl::StrCat("internal error: ", text,
                                            "; please report it with the command that you gave"));
  } catch (...) {
    return absl::InternalError(
        "internal error: an unknown exception; please report it with the command that you gave");
  }
}

}  // namespace egosieve::kernels
