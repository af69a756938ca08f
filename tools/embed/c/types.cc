#include "tools/embed/include/egosieve/types.h"

#include <cstdio>
#include <iterator>
#include <string>

#include "kernels/base/parallel_for.h"
#include "kernels/runtime/device.h"
#include "tools/cli/version.h"
#include "tools/embed/c/call.h"

namespace egosieve::embed {
namespace {

// Long enough for any message. A plain array needs no allocation and no destructor.
thread_local char last_error[1024] = "";

}  // namespace

extern "C" {

void egosieve_internal_set_last_error(const char* function, const char* text) {
  std::snprintf(last_error, sizeof last_error, "%s: %s", function, text);
}

int32_t egosieve_abi_version(void) { return EGOSIEVE_ABI_VERSION; }

const char* egosieve_version(void) { return tools::kVersion; }

const char* egosieve_last_error(void) { return last_error; }

const char* egosieve_status_name(egosieve_status status) {
  static constexpr const char* kNames[] = {
      "ok",        "invalid argument", "invalid handle", "failed precondition", "not found",
      "data loss", "unimplemented",    "unavailable",    "out of memory",       "internal error",
      "cancelled"};
  return status >= 0 && status < static_cast<int32_t>(std::size(kNames)) ? kNames[status]
                                                                         : "unknown status";
}

void egosieve_set_threads(int32_t threads) { kernels::SetMaximumThreads(threads); }

int32_t egosieve_threads(void) { return kernels::MaximumThreads(); }

egosieve_status egosieve_device_count(int32_t* count) {
  return Guard(__func__, [&] {
    RequirePointer("count", count);
    *count = static_cast<int32_t>(Take(kernels::ListDevices()).size());
  });
}

egosieve_status egosieve_device_name(int32_t index, char* text, int64_t capacity) {
  return Guard(__func__, [&] {
    RequirePointer("text", text);
    Require(capacity >= 1, "capacity = %d; at least 1", capacity);
    const auto devices = Take(kernels::ListDevices());
    Require(index >= 0 && index < static_cast<int32_t>(devices.size()),
            "index = %d; there are %d devices", index, devices.size());
    const std::string line = absl::StrFormat("%s: %s", kernels::DeviceTypeName(devices[index].type),
                                             devices[index].name);
    text[line.copy(text, capacity - 1)] = '\0';
  });
}

}  // extern "C"

}  // namespace egosieve::embed
