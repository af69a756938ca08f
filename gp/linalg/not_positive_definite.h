// The status of a matrix that is not positive definite to working precision. It is a
// FailedPrecondition that can be distinguished from others, such as a device that a forked process
// cannot use. Jitter and other hyperparameters help against this one alone.
//
// Jitter for a diagonal whose factorisation refuses a pivot: 1e-10 of the matrix's unit (a prior
// variance), then ten times more at each step up to 1e-4 of it.
#pragma once

#include <algorithm>
#include <optional>

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

inline constexpr double kFirstJitter = 1e-10;  // of the unit
inline constexpr double kLastJitter = 1e-4;

// The next larger jitter after `jitter`; nothing after the last.
inline std::optional<double> NextJitter(double jitter, double unit) {
  if (!(jitter < kLastJitter * unit)) return std::nullopt;
  return std::max(10.0 * jitter, kFirstJitter * unit);
}

}  // namespace egosieve::gp
