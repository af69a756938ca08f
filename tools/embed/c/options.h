// The caller's pointers, texts, and structs that may grow: their first field is the size with which
// the caller was compiled.
#ifndef EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_
#define EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::embed {

inline absl::Status CheckPointer(const char* name, const void* pointer) {
  return pointer != nullptr ? absl::OkStatus()
                            : absl::InvalidArgumentError(absl::StrCat(name, " is null"));
}

// Checks the size that the caller's struct states: it must be that of this version or of an older
// one. Structs grow at their ends by multiples of 8 bytes, so an older struct is a shorter one. A
// longer struct has fields that this version does not know.
template <typename Struct>
absl::Status CheckStruct(const char* name, const Struct* given) {
  constexpr uint64_t kSmallest = 2 * sizeof(uint64_t);  // the size and a field
  static_assert(sizeof(Struct) % sizeof(uint64_t) == 0);
  if (given == nullptr) return absl::InvalidArgumentError(absl::StrCat(name, " is null"));
  if (given->struct_size < kSmallest || given->struct_size > sizeof(Struct) ||
      given->struct_size % sizeof(uint64_t) != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ".struct_size = ", given->struct_size, "; call the struct's _init ",
                     "function, and build against the headers of this library's version"));
  }
  return absl::OkStatus();
}

// Copies the caller's fields over `values`; fields that an older caller lacks stay as they are.
template <typename Struct>
absl::Status ReadStruct(const char* name, const Struct* given, Struct& values) {
  if (absl::Status status = CheckStruct(name, given); !status.ok()) return status;
  std::memcpy(&values, given, given->struct_size);
  return absl::OkStatus();
}

// Sets a field of the caller's struct if the struct is long enough to have it.
template <typename Struct, typename Value>
void WriteField(Value Struct::*field, Value value, Struct* given) {
  const auto* end = reinterpret_cast<const char*>(&(given->*field) + 1);
  const auto* begin = reinterpret_cast<const char*>(given);
  if (static_cast<uint64_t>(end - begin) <= given->struct_size) given->*field = value;
}

// Copies as much of `values` as fits into the caller's struct.
template <typename Struct>
void WriteStruct(Struct values, Struct* given) {
  values.struct_size = given->struct_size;
  std::memcpy(given, &values, given->struct_size);
}

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

#endif  // EGOSIEVE_TOOLS_EMBED_C_OPTIONS_H_
