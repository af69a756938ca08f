/**
 * @file result.hpp
 * Results of the C++ interface: a Status, or a Result, which holds a value or a Status.
 *
 * Only Result::value() and Status::ThrowIfError() throw Error; the rest of the interface returns a
 * status. C++17 and later.
 */
#ifndef EGOSIEVE_RESULT_HPP_
#define EGOSIEVE_RESULT_HPP_

#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "types.h"

namespace egosieve {

/** Kinds of status; the numbers are those of #egosieve_status. */
enum class Code : int32_t {
  kOk = EGOSIEVE_OK,                                  /**< Done. */
  kInvalidArgument = EGOSIEVE_INVALID_ARGUMENT,       /**< The message names the argument. */
  kInvalidHandle = EGOSIEVE_INVALID_HANDLE,           /**< The object was moved from. */
  kFailedPrecondition = EGOSIEVE_FAILED_PRECONDITION, /**< The object's state does not allow it. */
  kNotFound = EGOSIEVE_NOT_FOUND,                     /**< No such file or device. */
  kDataLoss = EGOSIEVE_DATA_LOSS,                     /**< A damaged or foreign file. */
  kUnimplemented = EGOSIEVE_UNIMPLEMENTED,            /**< Written by a later version. */
  kUnavailable = EGOSIEVE_UNAVAILABLE,                /**< The system or the device failed. */
  kOutOfMemory = EGOSIEVE_OUT_OF_MEMORY,              /**< Memory ran out. */
  kInternal = EGOSIEVE_INTERNAL,                      /**< A defect of the library. */
  kCancelled = EGOSIEVE_CANCELLED                     /**< The caller stopped the call. */
};

/** The exception that value() and ThrowIfError() throw. */
class Error : public std::runtime_error {
 public:
  /** An exception with a code; what() is `message`. */
  Error(Code code, const std::string& message) : std::runtime_error(message), code_(code) {}
  /** The kind of error. */
  Code code() const { return code_; }

 private:
  Code code_;
};

/** The outcome of a call: a code and, for errors, what went wrong, where, and what to do. */
class [[nodiscard]] Status {
 public:
  /** Done. */
  Status() = default;
  /** An error. */
  Status(Code code, std::string message) : code_(code), message_(std::move(message)) {}

  /** The status of a C call on this thread that has just returned `code`. */
  static Status FromC(egosieve_status code) {
    return code == EGOSIEVE_OK ? Status() : Status(static_cast<Code>(code), egosieve_last_error());
  }

  /** Whether the call succeeded. */
  bool ok() const { return code_ == Code::kOk; }
  /** The kind of status. */
  Code code() const { return code_; }
  /** Empty if ok(). */
  const std::string& message() const { return message_; }

  /** Throws Error unless ok(); without exceptions, ends the program. */
  void ThrowIfError() const {
    if (ok()) return;
#if defined(__cpp_exceptions)
    throw Error(code_, message_);
#else
    std::terminate();
#endif
  }

 private:
  Code code_ = Code::kOk;
  std::string message_;
};

/** A value, or the Status that says why there is no value. */
template <typename T>
class [[nodiscard]] Result {
 public:
  /** A value. */
  Result(T value) : value_(std::move(value)) {}
  /** No value; `status` is not ok(). */
  Result(Status status) : status_(std::move(status)) {}

  /** Whether there is a value. */
  bool ok() const { return value_.has_value(); }
  /** Why there is no value. */
  const Status& status() const { return status_; }

  /** The value; throws Error if there is no value. */
  T& value() & {
    status_.ThrowIfError();
    return *value_;
  }
  /** The value; throws Error if there is no value. */
  const T& value() const& {
    status_.ThrowIfError();
    return *value_;
  }
  /** The value; throws Error if there is no value. */
  T&& value() && {
    status_.ThrowIfError();
    return std::move(*value_);
  }

  /** The value; needs ok(). */
  T& operator*() & { return *value_; }
  /** The value; needs ok(). */
  const T& operator*() const& { return *value_; }
  /** The value; needs ok(). */
  T&& operator*() && { return std::move(*value_); }
  /** The value; needs ok(). */
  T* operator->() { return &*value_; }
  /** The value; needs ok(). */
  const T* operator->() const { return &*value_; }

 private:
  std::optional<T> value_;
  Status status_;
};

namespace internal {

/** `value`, which the C call that gave `code` has set, or the call's status. */
template <typename T>
Result<T> Given(egosieve_status code, T& value) {
  if (code != EGOSIEVE_OK) return Status::FromC(code);
  return std::move(value);
}

/** The owner of the handle that the C call that gave `code` has set, or the call's status. */
template <typename Object, typename Handle>
Result<Object> Own(egosieve_status code, Handle* const& handle) {
  if (code != EGOSIEVE_OK) return Status::FromC(code);
  return Object(handle);
}

}  // namespace internal

/** Owns a handle of the C interface. A moved-from object may only be assigned to or destroyed. */
template <typename Handle, egosieve_status (*kFree)(Handle*)>
class Owner {
 public:
  /** Takes ownership of the handle. */
  explicit Owner(Handle* handle) : handle_(handle) {}
  /** Takes the other's handle. */
  Owner(Owner&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Exchanges the handles. */
  Owner& operator=(Owner&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Owner() { kFree(handle_); }

  /** The handle, still owned by this object. */
  Handle* handle() const { return handle_; }

 protected:
  /** The status of a C call whose first argument is the handle. */
  template <typename Function, typename... Arguments>
  Status Call(Function function, Arguments... arguments) const {
    return Status::FromC(function(handle_, arguments...));
  }

  Handle* handle_; /**< Null once moved from. */
};

}  // namespace egosieve

#endif  // EGOSIEVE_RESULT_HPP_
