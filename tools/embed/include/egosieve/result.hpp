/**
 * @file result.hpp
 * How calls of the C++ interface end: a Status, or a Result that holds a value or a Status.
 *
 * Nothing throws unless it is asked to: Result::value() and Status::ThrowIfError() throw Error, the
 * rest of the interface returns. C++17 and later.
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

/** What kind of end a call had; the numbers are those of #egosieve_status. */
enum class Code : int32_t {
  kOk = EGOSIEVE_OK,                                  /**< Done. */
  kInvalidArgument = EGOSIEVE_INVALID_ARGUMENT,       /**< The message names the argument. */
  kInvalidHandle = EGOSIEVE_INVALID_HANDLE,           /**< The object was moved from. */
  kFailedPrecondition = EGOSIEVE_FAILED_PRECONDITION, /**< Not as the object is. */
  kNotFound = EGOSIEVE_NOT_FOUND,                     /**< No such file or device. */
  kDataLoss = EGOSIEVE_DATA_LOSS,                     /**< A damaged or foreign file. */
  kUnimplemented = EGOSIEVE_UNIMPLEMENTED,            /**< A later version wrote this. */
  kUnavailable = EGOSIEVE_UNAVAILABLE,                /**< The system or the device failed. */
  kOutOfMemory = EGOSIEVE_OUT_OF_MEMORY,              /**< Memory ran out. */
  kInternal = EGOSIEVE_INTERNAL                       /**< A defect of the library. */
};

/** The exception of those who prefer exceptions. */
class Error : public std::runtime_error {
 public:
  /** An exception with a code and what() = `message`. */
  Error(Code code, const std::string& message) : std::runtime_error(message), code_(code) {}
  /** The kind of error. */
  Code code() const { return code_; }

 private:
  Code code_;
};

/** The end of a call: a code and, for errors, what went wrong, where, and what to do. */
class [[nodiscard]] Status {
 public:
  /** Done. */
  Status() = default;
  /** An error. */
  Status(Code code, std::string message) : code_(code), message_(std::move(message)) {}

  /** The status of a call of the C interface on this thread that has just returned `code`. */
  static Status FromC(egosieve_status code) {
    return code == EGOSIEVE_OK ? Status() : Status(static_cast<Code>(code), egosieve_last_error());
  }

  /** Whether the call did what it should. */
  bool ok() const { return code_ == Code::kOk; }
  /** The kind of end. */
  Code code() const { return code_; }
  /** Empty where ok(). */
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

/** A value, or the Status that says why there is none. */
template <typename T>
class [[nodiscard]] Result {
 public:
  /** A value. */
  Result(T value) : value_(std::move(value)) {}
  /** No value; `status` is not ok(). */
  Result(Status status) : status_(std::move(status)) {}

  /** Whether there is a value. */
  bool ok() const { return value_.has_value(); }
  /** Why there is none. */
  const Status& status() const { return status_; }

  /** The value; throws Error where there is none. */
  T& value() & {
    status_.ThrowIfError();
    return *value_;
  }
  /** The value; throws Error where there is none. */
  const T& value() const& {
    status_.ThrowIfError();
    return *value_;
  }
  /** The value; throws Error where there is none. */
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

}  // namespace egosieve

#endif  // EGOSIEVE_RESULT_HPP_
