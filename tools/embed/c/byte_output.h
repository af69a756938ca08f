// Copies bytes into the caller's buffer.
#ifndef EGOSIEVE_TOOLS_EMBED_C_BYTE_OUTPUT_H_
#define EGOSIEVE_TOOLS_EMBED_C_BYTE_OUTPUT_H_

#include <cstdint>
#include <cstring>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::embed {

// Copies `text` to `bytes`, unless that is null, and its size to `*size`. If the buffer is too
// small, InvalidArgument with the size needed, and nothing is written.
inline absl::Status GiveBytes(std::string_view text, void* bytes, int64_t capacity, int64_t* size) {
  if (size == nullptr) return absl::InvalidArgumentError("size is null");
  const auto needed = static_cast<int64_t>(text.size());
  if (bytes != nullptr && !(capacity >= needed)) {
    return absl::InvalidArgumentError(
        absl::StrCat("capacity = ", capacity, " bytes; ", needed, " are needed"));
  }
  if (bytes != nullptr) std::memcpy(bytes, text.data(), text.size());
  *size = needed;
  return absl::OkStatus();
}

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_BYTE_OUTPUT_H_
