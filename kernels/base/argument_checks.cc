#include "kernels/base/argument_checks.h"

#include <cmath>

namespace egosieve::kernels {

absl::Status CheckShape(std::string_view name, const void* data, int64_t rows, int64_t cols,
                        int64_t stride, int64_t expected_rows, int64_t expected_cols) {
  EGOSIEVE_REQUIRE(InvalidArgument, rows == expected_rows && cols == expected_cols,
                   "%s is %d x %d; it must be %d x %d", name, rows, cols, expected_rows,
                   expected_cols);
  EGOSIEVE_REQUIRE(InvalidArgument, stride >= cols,
                   "%s has stride %d; it must be at least its %d columns", name, stride, cols);
  EGOSIEVE_REQUIRE(InvalidArgument, data != nullptr || rows == 0 || cols == 0,
                   "%s is %d x %d but its data is null", name, rows, cols);
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
      EGOSIEVE_REQUIRE(InvalidArgument, std::isfinite(row[j]), "%s(%d, %d) = %g; it must be finite",
                       name, i, j, row[j]);
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
