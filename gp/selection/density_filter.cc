#include "gp/selection/density_filter.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <numeric>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

template <typename T>
struct PointCloud {
  ConstMatrixView<T> points;
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
absl::Status Check(ConstMatrixView<T> inputs, absl::Span<const double> labels,
                   const DensityFilterOptions& options, absl::Span<const int64_t> order) {
  if (static_cast<int64_t>(labels.size()) != inputs.rows) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d inputs and %d labels", inputs.rows, labels.size()));
  }
  if (!(options.radius >= 0.0) || std::isinf(options.radius)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("radius = %g; it must be finite and not negative", options.radius));
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
  if (order.empty()) return absl::OkStatus();
  std::vector<bool> seen(labels.size(), false);
  for (const int64_t i : order) {
    if (!(i >= 0 && i < inputs.rows) || seen[i]) break;
    seen[i] = true;
  }
  if (order.size() != labels.size() || std::count(seen.begin(), seen.end(), true) != inputs.rows) {
    return absl::InvalidArgumentError("order is not a permutation of the rows");
  }
  return absl::OkStatus();
}

template <typename T>
absl::StatusOr<std::vector<int64_t>> Filter(ConstMatrixView<T> inputs,
                                            absl::Span<const double> labels,
                                            const DensityFilterOptions& options,
                                            absl::Span<const int64_t> order) {
  if (absl::Status status = Check(inputs, labels, options, order); !status.ok()) return status;
  const int64_t n = inputs.rows;
  std::vector<int64_t> sequence(order.begin(), order.end());
  if (order.empty()) {
    sequence.resize(n);
    std::iota(sequence.begin(), sequence.end(), int64_t{0});
  }
  std::vector<bool> dropped(n, false);
  if (options.radius > 0.0 && n > 1) {
    using Metric = nanoflann::L2_Simple_Adaptor<double, PointCloud<T>, double, size_t>;
    using Tree = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointCloud<T>, -1, size_t>;
    const PointCloud<T> cloud{inputs};
    const Tree tree(inputs.cols, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    std::vector<std::pair<size_t, double>> neighbours;
    std::vector<double> query(inputs.cols);
    nanoflann::SearchParams unsorted;
    unsorted.sorted = false;
    for (const int64_t i : sequence) {
      if (dropped[i]) continue;
      std::copy(inputs.row(i), inputs.row(i) + inputs.cols, query.begin());
      tree.radiusSearch(query.data(), options.radius * options.radius, neighbours, unsorted);
      for (const auto& [j, squared_distance] : neighbours) {
        // A point kept earlier would have dropped i were they close and of one side: all that are
        // found come later.
        if (static_cast<int64_t>(j) != i && (labels[j] >= 0.5) == (labels[i] >= 0.5)) {
          dropped[j] = true;
        }
      }
    }
  }
  std::vector<int64_t> kept;
  for (int64_t i = 0; i < n; ++i) {
    if (!dropped[i]) kept.push_back(i);
  }
  return kept;
}

}  // namespace

absl::StatusOr<std::vector<int64_t>> FilterByDensity(ConstMatrixView<double> inputs,
                                                     absl::Span<const double> labels,
                                                     const DensityFilterOptions& options,
                                                     absl::Span<const int64_t> order) {
  return Filter(inputs, labels, options, order);
}

absl::StatusOr<std::vector<int64_t>> FilterByDensity(ConstMatrixView<float> inputs,
                                                     absl::Span<const double> labels,
                                                     const DensityFilterOptions& options,
                                                     absl::Span<const int64_t> order) {
  return Filter(inputs, labels, options, order);
}

}  // namespace egosieve::gp
