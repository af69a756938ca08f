#include "tools/embed/include/egosieve/types.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/device.h"
#include "tools/cli/version.h"
#include "tools/embed/c/last_error.h"

namespace {

// Long enough for any message. A plain array needs no allocation and no destructor.
thread_local char last_error[1024] = "";

}  // namespace

extern "C" {

void egosieve_internal_set_last_error(const char* function, const char* text) {
  std::snprintf(last_error, sizeof last_error, "%s: %s", function, text);
}

int32_t egosieve_abi_version(void) { return EGOSIEVE_ABI_VERSION; }

const char* egosieve_version(void) { return egosieve::tools::kVersion; }

const char* egosieve_last_error(void) { return last_error; }

const char* egosieve_status_name(egosieve_status status) {
  static constexpr const char* kNames[] = {
      "ok",        "invalid argument", "invalid handle", "failed precondition", "not found",
      "data loss", "unimplemented",    "unavailable",    "out of memory",       "internal error",
      "cancelled"};
  return status >= 0 && status < static_cast<int32_t>(std::size(kNames)) ? kNames[status]
                                                                         : "unknown status";
}

void egosieve_set_threads(int32_t threads) { egosieve::kernels::SetMaximumThreads(threads); }

int32_t egosieve_threads(void) { return egosieve::kernels::MaximumThreads(); }

egosieve_status egosieve_device_count(int32_t* count) {
  return egosieve::embed::Guard(__func__, [&]() -> absl::Status {
    if (count == nullptr) return absl::InvalidArgumentError("count is null");
    EGOSIEVE_ASSIGN_OR_RETURN(const auto devices, egosieve::kernels::ListDevices());
    *count = static_cast<int32_t>(devices.size());
    return absl::OkStatus();
  });
}

egosieve_status egosieve_device_name(int32_t index, char* text, int64_t capacity) {
  return egosieve::embed::Guard(__func__, [&]() -> absl::Status {
    if (text == nullptr) return absl::InvalidArgumentError("text is null");
    if (!(capacity >= 1)) {
      return absl::InvalidArgumentError(absl::StrCat("capacity = ", capacity, "; at least 1"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const auto devices, egosieve::kernels::ListDevices());
    if (index < 0 || index >= static_cast<int32_t>(devices.size())) {
      return absl::InvalidArgumentError(
          absl::StrCat("index = ", index, "; there are ", devices.size(), " devices"));
    }
    const std::string line = absl::StrCat(egosieve::kernels::DeviceTypeName(devices[index].type),
                                          ": ", devices[index].name);
    const int64_t length = std::min<int64_t>(line.size(), capacity - 1);
    std::copy_n(line.data(), length, text);
    text[length] = '\0';
    return absl::OkStatus();
  });
}

}  // extern "C"
