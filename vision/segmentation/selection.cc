#include "vision/segmentation/selection.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <numeric>
#include <tuple>

#include "vision/segmentation/rows.h"

namespace egosieve::vision {
namespace {

using PointTree = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<double, PointCloud, double, size_t>, PointCloud, -1, size_t>;

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

std::vector<int64_t> FilterByDensity(kernels::ConstMatrixView<double> inputs,
                                     absl::Span<const double> labels, double radius,
                                     absl::Span<const int64_t> order) {
  const int64_t n = inputs.rows;
  std::vector<int64_t> sequence(order.begin(), order.end());
  if (order.empty()) {
    sequence.resize(n);
    std::iota(sequence.begin(), sequence.end(), int64_t{0});
  }
  std::vector<bool> dropped(n, false);
  if (radius > 0.0 && n > 1) {
    const PointCloud cloud{inputs};
    const PointTree tree(inputs.cols, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    Dropper dropper(labels, radius * radius, dropped);
    for (const int64_t i : sequence) {
      if (dropped[i]) continue;
      dropper.StartAt(i);
      tree.findNeighbors(dropper, inputs.row(i), {});
    }
  }
  std::vector<int64_t> kept;
  for (int64_t i = 0; i < n; ++i) {
    if (!dropped[i]) kept.push_back(i);
  }
  return kept;
}

std::vector<int64_t> FilterByAgreement(absl::Span<const double> labels,
                                       absl::Span<const float> predictions, bool agreeing) {
  std::vector<int64_t> kept;
  for (size_t i = 0; i < labels.size(); ++i) {
    const bool agrees = (labels[i] >= 0.5) == (static_cast<double>(predictions[i]) >= 0.5);
    if (agrees == agreeing) kept.push_back(static_cast<int64_t>(i));
  }
  return kept;
}

BudgetDecision EnforceBudget(absl::Span<const double> labels,
                             absl::Span<const int64_t> insertion_times, int64_t time,
                             const BudgetOptions& options, absl::Span<const double> rank) {
  BudgetDecision decision;
  std::vector<int64_t> left;
  int64_t class_sizes[2] = {0, 0};
  for (int64_t i = 0; i < static_cast<int64_t>(labels.size()); ++i) {
    const int64_t age = time - insertion_times[i];
    const bool is_positive = labels[i] >= 0.5;
    if (age > options.maximum_age || (is_positive && age > options.maximum_positive_age)) {
      decision.dropped.push_back(i);
      ++decision.dropped_for_age;
    } else {
      left.push_back(i);
      ++class_sizes[is_positive ? 1 : 0];
    }
  }
  int64_t excess = static_cast<int64_t>(left.size()) - options.budget;
  if (excess > 0) {
    const int rare = class_sizes[1] < class_sizes[0] ? 1 : 0;
    const int64_t share =
        static_cast<int64_t>(std::floor(options.rare_class_share * options.budget));
    int64_t droppable[2] = {class_sizes[0], class_sizes[1]};
    droppable[rare] -= std::min(class_sizes[rare], share);  // (BU1)
    std::sort(left.begin(), left.end(), [&](int64_t i, int64_t j) {
      return std::make_tuple(insertion_times[i], rank[i], i) <
             std::make_tuple(insertion_times[j], rank[j], j);
    });
    for (const int64_t i : left) {
      const int side = labels[i] >= 0.5 ? 1 : 0;
      if (excess == 0) break;
      if (droppable[side] == 0) continue;
      --droppable[side];
      --excess;
      decision.dropped.push_back(i);
      ++decision.dropped_for_budget;
    }
  }
  std::sort(decision.dropped.begin(), decision.dropped.end());
  return decision;
}

}  // namespace egosieve::vision
