// Argument checks that the public operations share. Every error names argument and value.
#ifndef EGOSIEVE_KERNELS_BASE_ARGUMENT_CHECKS_H_
#define EGOSIEVE_KERNELS_BASE_ARGUMENT_CHECKS_H_

#include <string_view>

#include "absl/status/status.h"
#include "kernels/base/matrix_view.h"

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

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_ARGUMENT_CHECKS_H_
