#include "kernels/base/argument_checks.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace egosieve::kernels {

absl::Status CheckShape(std::string_view name, const void* data, int64_t rows, int64_t cols,
                        int64_t stride, int64_t expected_rows, int64_t expected_cols) {
  if (rows != expected_rows || cols != expected_cols) {
    return absl::InvalidArgumentError(absl::StrFormat("%s is %d x %d; it must be %d x %d", name,
                                                      rows, cols, expected_rows, expected_cols));
  }
  if (stride < cols) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s has stride %d; it must be at least its %d columns", name, stride, cols));
  }
  if (data == nullptr && rows > 0 && cols > 0) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s is %d x %d but its data is null", name, rows, cols));
  }
  return absl::OkStatus();
}

template <typename T>
absl::Status CheckFinite(std::string_view name, ConstMatrixView<T> view) {
  for (int64_t i = 0; i < view.rows; ++i) {
    const T* row = view.row(i);
    // 0 * x is 0 for finite x and NaN otherwise, and NaN propagates through the sum: no branch in
    // the loop.
    T sum = 0;
    for (int64_t j = 0; j < view.cols; ++j) {
      sum += T{0} * row[j];
    }
    if (sum == T{0}) {
      continue;
    }
    for (int64_t j = 0; j < view.cols; ++j) {
      if (!std::isfinite(row[j])) {
        return absl::InvalidArgumentError(
            absl::StrFormat("%s(%d, %d) = %g; it must be finite", name, i, j, row[j]));
      }
    }
  }
  return absl::OkStatus();
}

template absl::Status CheckFinite(std::string_view, ConstMatrixView<float>);
template absl::Status CheckFinite(std::string_view, ConstMatrixView<double>);

absl::Status CheckOptions(std::initializer_list<OptionCheck> checks) {
  for (const OptionCheck& check : checks) {
    if (check.holds) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(check.name, " is ", check.value, "; it must ", check.rule));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::kernels
