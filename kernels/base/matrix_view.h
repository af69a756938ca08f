// Non-owning view of a row-major matrix: element (i, j) is data[i * stride + j], stride >= cols. A
// set of N points in D dimensions is an N x D view, one point per row.
#pragma once

#include <cstdint>
#include <type_traits>

namespace egosieve::kernels {

template <typename T>
struct MatrixView {
  T* data = nullptr;
  int64_t rows = 0;
  int64_t cols = 0;
  int64_t stride = 0;

  MatrixView() = default;
  MatrixView(T* data, int64_t rows, int64_t cols) : MatrixView(data, rows, cols, cols) {}
  MatrixView(T* data, int64_t rows, int64_t cols, int64_t stride)
      : data(data), rows(rows), cols(cols), stride(stride) {}
  // A view of mutable elements converts to a view of constant ones.
  template <typename U, typename = std::enable_if_t<std::is_same_v<const U, T>>>
  MatrixView(const MatrixView<U>& other)
      : MatrixView(other.data, other.rows, other.cols, other.stride) {}

  T* row(int64_t i) const { return data + i * stride; }
  T& operator()(int64_t i, int64_t j) const { return data[i * stride + j]; }
  bool empty() const { return rows == 0 || cols == 0; }
  MatrixView rows_between(int64_t begin, int64_t end) const {
    return MatrixView(row(begin), end - begin, cols, stride);
  }
};

template <typename T>
using ConstMatrixView = MatrixView<const T>;

}  // namespace egosieve::kernels
