// Argument checks that the public operations share, and checks of options. Every error names
// argument and value.
#pragma once

#include <cmath>
#include <initializer_list>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "kernels/base/matrix_view.h"

// Returns an error of this kind, such as InvalidArgument, with this text, in StrFormat's manner,
// from the enclosing function unless the condition holds.
#define EGOSIEVE_REQUIRE(kind, condition, ...)                \
  do {                                                        \
    if (!(condition)) {                                       \
      return absl::kind##Error(absl::StrFormat(__VA_ARGS__)); \
    }                                                         \
  } while (false)

namespace egosieve::kernels {

// Rows and columns as expected, stride >= columns, and data non-null unless the view is empty.
absl::Status CheckShape(std::string_view name, const void* data, int64_t rows, int64_t cols,
                        int64_t stride, int64_t expected_rows, int64_t expected_cols);

template <typename T>
absl::Status CheckShape(std::string_view name, const MatrixView<T>& view, int64_t expected_rows,
                        int64_t expected_cols) {
  return CheckShape(name, view.data, view.rows, view.cols, view.stride, expected_rows,
                    expected_cols);
}

// InvalidArgument, naming the first element that is NaN or infinite.
template <typename T>
absl::Status CheckFinite(std::string_view name, ConstMatrixView<T> view);

struct OptionCheck {
  const char* name;
  absl::AlphaNum value;
  bool holds;
  absl::string_view rule;  // "be positive"
};

// InvalidArgument, "`name` is `value`; it must `rule`", for the first one that does not hold.
absl::Status CheckOptions(std::initializer_list<OptionCheck> checks);

inline bool IsPositive(double value) { return value > 0 && std::isfinite(value); }
inline bool IsNotNegative(double value) { return value >= 0 && std::isfinite(value); }

}  // namespace egosieve::kernels
