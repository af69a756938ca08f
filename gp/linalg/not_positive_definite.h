// The status of a matrix that is not positive definite to working precision. It is a
// FailedPrecondition that can be distinguished from others, such as a device that a forked process
// cannot use. Jitter and other hyperparameters help against this one alone.
#pragma once

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/string_view.h"

namespace egosieve::gp {

inline constexpr char kNotPositiveDefinite[] = "egosieve/not_positive_definite";

inline absl::Status NotPositiveDefinite(absl::string_view message) {
  absl::Status status = absl::FailedPreconditionError(message);
  status.SetPayload(kNotPositiveDefinite, absl::Cord());
  return status;
}

inline bool IsNotPositiveDefinite(const absl::Status& status) {
  return status.GetPayload(kNotPositiveDefinite).has_value();
}

}  // namespace egosieve::gp
