// Jitter for a diagonal whose factorisation refuses a pivot: 1e-10 of the matrix's unit (a prior
// variance), then ten times more at each step up to 1e-4 of it.
#pragma once

#include <algorithm>
#include <optional>

namespace egosieve::gp {

inline constexpr double kFirstJitter = 1e-10;  // of the unit
inline constexpr double kLastJitter = 1e-4;

// The next larger jitter after `jitter`; nothing after the last.
inline std::optional<double> NextJitter(double jitter, double unit) {
  if (!(jitter < kLastJitter * unit)) return std::nullopt;
  return std::max(10.0 * jitter, kFirstJitter * unit);
}

}  // namespace egosieve::gp
