// Structs of the C interface that may grow: they begin with the size that their caller was compiled
// with.
#ifndef EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_
#define EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::embed {

inline absl::Status CheckPointer(const char* name, const void* pointer) {
  return pointer != nullptr ? absl::OkStatus()
                            : absl::InvalidArgumentError(absl::StrCat(name, " is null"));
}

// What the caller's struct may say of its size: that of this version, or less down to the first
// version's, `smallest`.
template <typename Struct>
absl::Status CheckStruct(const char* name, const Struct* given,
                         uint64_t smallest = sizeof(Struct)) {
  if (given == nullptr) return absl::InvalidArgumentError(absl::StrCat(name, " is null"));
  if (given->struct_size < smallest || given->struct_size > sizeof(Struct)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ".struct_size = ", given->struct_size, "; call the struct's _init ",
                     "function, and build against the headers of this library's version"));
  }
  return absl::OkStatus();
}

// Copies the caller's fields over `values`; what an older caller does not know stays.
template <typename Struct>
absl::Status ReadStruct(const char* name, const Struct* given, Struct& values) {
  if (absl::Status status = CheckStruct(name, given); !status.ok()) return status;
  std::memcpy(&values, given, given->struct_size);
  return absl::OkStatus();
}

// Copies `values` into the caller's struct, as much as there is room.
template <typename Struct>
void WriteStruct(Struct values, Struct* given) {
  values.struct_size = given->struct_size;
  std::memcpy(given, &values, given->struct_size);
}

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_
