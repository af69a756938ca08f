#include "gp/selection/contradiction_filter.h"

#include <numeric>

#include "gp/selection/labelled_points.h"

namespace egosieve::gp {

absl::StatusOr<std::vector<int64_t>> FilterByContradiction(
    kernels::ConstMatrixView<double> inputs, absl::Span<const double> labels,
    kernels::ConstMatrixView<float> newer_inputs, absl::Span<const double> newer_labels,
    double radius) {
  for (const absl::Status& status : {CheckLabelledPoints(inputs, labels, radius),
                                     CheckLabelledPoints(newer_inputs, newer_labels, radius)}) {
    if (!status.ok()) return status;
  }
  std::vector<int64_t> kept(inputs.rows);
  std::iota(kept.begin(), kept.end(), int64_t{0});
  if (!(radius > 0.0) || inputs.rows == 0 || newer_inputs.rows == 0) return kept;
  if (inputs.cols != newer_inputs.cols) {
    return absl::InvalidArgumentError(
        absl::StrFormat("inputs of dimension %d and %d", inputs.cols, newer_inputs.cols));
  }
  const PointCloud<float> cloud{newer_inputs};
  const PointTree<float> tree(inputs.cols, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  std::erase_if(kept, [&](int64_t i) {
    size_t nearest = 0;
    double squared_distance = 0.0;
    tree.knnSearch(inputs.row(i), 1, &nearest, &squared_distance);
    return squared_distance < radius * radius &&
           (newer_labels[nearest] >= 0.5) != (labels[i] >= 0.5);
  });
  return kept;
}

}  // namespace egosieve::gp
