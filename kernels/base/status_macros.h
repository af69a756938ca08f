// Early return with a status: absl has no macros for it in Debian 12's version.
#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Returns from the enclosing function with the status of `expression` unless it is OK.
#define EGOSIEVE_RETURN_IF_ERROR(expression)                  \
  do {                                                        \
    if (absl::Status status_ = (expression); !status_.ok()) { \
      return status_;                                         \
    }                                                         \
  } while (false)

// Evaluates `expression`, an absl::StatusOr<T>; assigns its value to `target` (which may declare a
// variable) or returns its status from the enclosing function.
#define EGOSIEVE_ASSIGN_OR_RETURN(target, expression) \
  EGOSIEVE_ASSIGN_OR_RETURN_(EGOSIEVE_JOIN_(status_or_, __LINE__), target, expression)

#define EGOSIEVE_ASSIGN_OR_RETURN_(temporary, target, expression) \
  auto temporary = (expression);                                  \
  if (!temporary.ok()) {                                          \
    return std::move(temporary).status();                         \
  }                                                               \
  target = *std::move(temporary)
#define EGOSIEVE_JOIN_(a, b) EGOSIEVE_JOIN_AGAIN_(a, b)
#define EGOSIEVE_JOIN_AGAIN_(a, b) a##b
