// Rows of matrices and vectors, by index, and as the points of a k-d tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

template <typename T>
std::vector<T> GatherRows(kernels::ConstMatrixView<T> matrix, absl::Span<const int64_t> rows) {
  std::vector<T> gathered;
  gathered.reserve(rows.size() * matrix.cols);
  for (const int64_t row : rows) {
    gathered.insert(gathered.end(), matrix.row(row), matrix.row(row) + matrix.cols);
  }
  return gathered;
}

template <typename T = double>
std::vector<T> Gather(std::type_identity_t<absl::Span<const T>> values,
                      absl::Span<const int64_t> rows) {
  std::vector<T> gathered;
  gathered.reserve(rows.size());
  for (const int64_t row : rows) gathered.push_back(values[row]);
  return gathered;
}

// Rows as nanoflann takes them.
struct PointCloud {
  kernels::ConstMatrixView<double> points;

  size_t kdtree_get_point_count() const { return static_cast<size_t>(points.rows); }
  double kdtree_get_pt(size_t row, size_t axis) const {
    return points(static_cast<int64_t>(row), static_cast<int64_t>(axis));
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// The rows of [0, count) that are not in `kept`; `kept` is increasing.
inline std::vector<int64_t> Complement(int64_t count, absl::Span<const int64_t> kept) {
  std::vector<int64_t> rest;
  size_t next = 0;
  for (int64_t row = 0; row < count; ++row) {
    if (next < kept.size() && kept[next] == row) {
      ++next;
    } else {
      rest.push_back(row);
    }
  }
  return rest;
}

}  // namespace egosieve::vision
