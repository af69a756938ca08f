// What all calls of the C interface share: errors, and the caller's pointers, texts and structs.
//
// Within a call an error is thrown; Guard makes it the call's code and the thread's last error.
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "tools/embed/include/egosieve/types.h"

// Exported so that both libraries share one last error per thread; not public.
extern "C" EGOSIEVE_API void egosieve_internal_set_last_error(const char* function,
                                                              const char* text);

namespace egosieve::embed {

// Abseil has no code for an invalid handle. The library uses this one only for that.
inline constexpr absl::StatusCode kInvalidHandle = absl::StatusCode::kUnauthenticated;

struct CallError {
  absl::Status status;
};

// Throws CallError unless `status` is OK.
inline void Check(absl::Status status) {
  if (!status.ok()) throw CallError{std::move(status)};
}

// The same status of the argument or file `name`.
inline absl::Status Named(std::string_view name, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrFormat("%s: %s", name, status.message()));
}

// The value, or CallError.
template <typename T>
T Take(absl::StatusOr<T> value) {
  Check(value.status());
  return *std::move(value);
}

// InvalidArgument with this text, in StrFormat's manner, unless `allowed`.
template <typename... Values>
void Require(bool allowed, const absl::FormatSpec<Values...>& text, const Values&... values) {
  if (!allowed) Check(absl::InvalidArgumentError(absl::StrFormat(text, values...)));
}

// The same with FailedPrecondition.
template <typename... Values>
void RequireState(bool allowed, const absl::FormatSpec<Values...>& text, const Values&... values) {
  if (!allowed) Check(absl::FailedPreconditionError(absl::StrFormat(text, values...)));
}

inline void RequirePointer(const char* name, const void* pointer) {
  Require(pointer != nullptr, "%s is null", name);
}

// Within a handler: makes the exception "function: message" of this thread, and gives its code.
egosieve_status ReportException(const char* function) noexcept;

// Runs a call's body.
template <typename Body>
egosieve_status Guard(const char* function, Body&& body) noexcept {
  try {
    body();
    return EGOSIEVE_OK;
  } catch (...) {
    return ReportException(function);
  }
}

// Structs that may grow begin with the size with which the caller was compiled. They grow at their
// ends by multiples of 8 bytes, so an older struct is a shorter one. A longer struct has fields
// that this version does not know.

// Sets every field to 0 but the size. False if `given` is null.
template <typename Struct>
bool Initialise(Struct* given) {
  if (given == nullptr) return false;
  *given = Struct{};
  given->struct_size = sizeof(Struct);
  return true;
}

template <typename Struct>
void CheckStruct(const char* name, const Struct* given) {
  constexpr uint64_t kSmallest = 2 * sizeof(uint64_t);  // the size and a field
  static_assert(sizeof(Struct) % sizeof(uint64_t) == 0);
  RequirePointer(name, given);
  Require(given->struct_size >= kSmallest && given->struct_size <= sizeof(Struct) &&
              given->struct_size % sizeof(uint64_t) == 0,
          "%s.struct_size = %d; call the struct's _init function, and build against the headers of "
          "this library's version",
          name, given->struct_size);
}

// The caller's fields; those that an older caller lacks have the values that `init` sets. If it is
// `optional`, null stands for these values.
template <typename Struct>
Struct Read(const char* name, const Struct* given, void (*init)(Struct*), bool optional = false) {
  Struct values;
  init(&values);
  if (optional && given == nullptr) return values;
  CheckStruct(name, given);
  std::memcpy(&values, given, given->struct_size);
  return values;
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
inline void GiveBytes(std::string_view text, void* bytes, int64_t capacity, int64_t* size) {
  RequirePointer("size", size);
  const auto needed = static_cast<int64_t>(text.size());
  Require(bytes == nullptr || capacity >= needed, "capacity = %d bytes; %d are needed", capacity,
          needed);
  if (bytes != nullptr) std::memcpy(bytes, text.data(), text.size());
  *size = needed;
}

}  // namespace egosieve::embed
