#include "vision/segmentation/density_filter.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <numeric>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

using kernels::ConstMatrixView;

// A k-d tree's view of rows.
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
using PointTree = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<double, PointCloud<T>, double, size_t>, PointCloud<T>, -1, size_t>;

// InvalidArgument, with the value, unless there is a label in [0, 1] for each row, the inputs are
// finite, and the radius is finite and not negative.
template <typename T>
absl::Status CheckLabelledPoints(ConstMatrixView<T> inputs, absl::Span<const double> labels,
                                 double radius) {
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

template <typename T>
absl::Status Check(ConstMatrixView<T> inputs, absl::Span<const double> labels, double radius,
                   absl::Span<const int64_t> order) {
  EGOSIEVE_RETURN_IF_ERROR(CheckLabelledPoints(inputs, labels, radius));
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

// Drops the rows of row i's side that the tree finds around it. An earlier kept point of that side
// would have dropped i, so all these rows come later in the order.
class Dropper {
 public:
  using DistanceType = double;
  Dropper(absl::Span<const double> labels, double squared_radius, std::vector<bool>& dropped)
      : labels_(labels), squared_radius_(squared_radius), dropped_(dropped) {}
  void StartAt(int64_t i) { i_ = i; }
  bool addPoint(double squared_distance, size_t j) {
    if (squared_distance < squared_radius_ && static_cast<int64_t>(j) != i_ &&
        (labels_[j] >= 0.5) == (labels_[i_] >= 0.5)) {
      dropped_[j] = true;
    }
    return true;
  }
  double worstDist() const { return squared_radius_; }
  bool full() const { return true; }
  void sort() {}

 private:
  absl::Span<const double> labels_;
  double squared_radius_;
  std::vector<bool>& dropped_;
  int64_t i_ = 0;
};

}  // namespace

template <typename T>
absl::StatusOr<std::vector<int64_t>> FilterByDensity(ConstMatrixView<T> inputs,
                                                     absl::Span<const double> labels, double radius,
                                                     absl::Span<const int64_t> order) {
  EGOSIEVE_RETURN_IF_ERROR(Check(inputs, labels, radius, order));
  const int64_t n = inputs.rows;
  std::vector<int64_t> sequence(order.begin(), order.end());
  if (order.empty()) {
    sequence.resize(n);
    std::iota(sequence.begin(), sequence.end(), int64_t{0});
  }
  std::vector<bool> dropped(n, false);
  if (radius > 0.0 && n > 1) {
    const PointCloud<T> cloud{inputs};
    const PointTree<T> tree(inputs.cols, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    Dropper dropper(labels, radius * radius, dropped);
    std::vector<double> query(inputs.cols);
    for (const int64_t i : sequence) {
      if (dropped[i]) continue;
      std::copy(inputs.row(i), inputs.row(i) + inputs.cols, query.begin());
      dropper.StartAt(i);
      tree.findNeighbors(dropper, query.data(), {});
    }
  }
  std::vector<int64_t> kept;
  for (int64_t i = 0; i < n; ++i) {
    if (!dropped[i]) kept.push_back(i);
  }
  return kept;
}

template absl::StatusOr<std::vector<int64_t>> FilterByDensity(ConstMatrixView<double>,
                                                              absl::Span<const double>, double,
                                                              absl::Span<const int64_t>);
template absl::StatusOr<std::vector<int64_t>> FilterByDensity(ConstMatrixView<float>,
                                                              absl::Span<const double>, double,
                                                              absl::Span<const int64_t>);

}  // namespace egosieve::vision
