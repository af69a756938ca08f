// Values and statuses of calls, for tests; GoogleTest and GoogleMock come with it.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "gmock/gmock.h"

namespace egosieve {

// The value, without which the test cannot go on, or an exception with the status, which fails it.
template <typename T>
T Value(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

inline const absl::Status& StatusIn(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusIn(const absl::StatusOr<T>& result) {
  return result.status();
}

// A status, or a result without a value, of this code; its message holds the words.
MATCHER_P2(IsError, code, words, "") {
  const absl::Status& status = StatusIn(arg);
  *result_listener << status;
  return status.code() == code && absl::StrContains(status.message(), words);
}

inline auto IsInvalid(const std::string& words = "") {
  return IsError(absl::StatusCode::kInvalidArgument, words);
}

}  // namespace egosieve
