// Common parts of the filters that compare places: a k-d tree's view of rows, and checks.
#pragma once

#include <cmath>
#include <cstdint>
#include <nanoflann.hpp>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

template <typename T>
struct PointCloud {
  kernels::ConstMatrixView<T> points;
  size_t kdtree_get_point_count() const { return static_cast<size_t>(points.rows); }
  double kdtree_get_pt(size_t i, size_t d) const {
    return static_cast<double>(points(static_cast<int64_t>(i), static_cast<int64_t>(d)));
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

template <typename T>
using PointTree = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<double, PointCloud<T>, double, size_t>, PointCloud<T>, -1, size_t>;

// InvalidArgument, with the value, unless there is a label in [0, 1] for each row, the inputs are
// finite, and the radius is finite and not negative.
template <typename T>
absl::Status CheckLabelledPoints(kernels::ConstMatrixView<T> inputs,
                                 absl::Span<const double> labels, double radius) {
  if (static_cast<int64_t>(labels.size()) != inputs.rows) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d inputs and %d labels", inputs.rows, labels.size()));
  }
  if (!(radius >= 0.0) || std::isinf(radius)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("radius = %g; it must be finite and not negative", radius));
  }
  for (int64_t i = 0; i < inputs.rows; ++i) {
    if (!(labels[i] >= 0.0 && labels[i] <= 1.0)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("labels[%d] = %g; it must be in [0, 1]", i, labels[i]));
    }
    for (int64_t d = 0; d < inputs.cols; ++d) {
      if (!std::isfinite(inputs(i, d))) {
        return absl::InvalidArgumentError(
            absl::StrFormat("inputs(%d, %d) = %g; it must be finite", i, d, inputs(i, d)));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
