#include "vision/baselines/dense_flow.h"

#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

absl::StatusOr<MotionModel> Estimate(const DenseFlow& flow, MotionModelChoice choice,
                                     uint64_t seed) {
  MotionModelOptions options;
  options.choice = choice;
  options.seed = seed;
  return EstimateMotionModel(flow.reliable, options);
}

}  // namespace

absl::StatusOr<DenseFlow> FlowAtGrid(const cv::Mat& first, const cv::Mat& second,
                                     const kernels::ImageGrid& grid) {
  const FlowGridOptions options;
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(first, second, options.quality));
  DenseFlow dense;
  dense.pairs.reserve(grid.size());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const cv::Point2f at(static_cast<float>(grid.x_pixels(column)),
                           static_cast<float>(grid.y_pixels(row)));
      const cv::Point2f back = SampleField(flow.backward, at);
      dense.pairs.push_back({at.x + back.x, at.y + back.y, at.x, at.y});
    }
  }
  const TrackedGrid tracked = TrackGrid(flow, first, second, /*anchor_second=*/true, options);
  for (size_t i = 0; i < tracked.pairs.size(); ++i) {
    if (tracked.is_textured[i] != 0) dense.reliable.push_back(tracked.pairs[i]);
  }
  return dense;
}

absl::StatusOr<std::vector<double>> HomographyDistances(const DenseFlow& flow, uint64_t seed) {
  EGOSIEVE_ASSIGN_OR_RETURN(const MotionModel model,
                            Estimate(flow, MotionModelChoice::kHomography, seed));
  if (model.kind == MotionModelKind::kNone) return std::vector<double>();
  return Residuals(model.kind, model.matrix, flow.pairs, EpipolarDistance::kSampson);
}

absl::StatusOr<MotionModel> FundamentalMatrixOf(const DenseFlow& flow, uint64_t seed) {
  return Estimate(flow, MotionModelChoice::kFundamental, seed);
}

}  // namespace egosieve::vision
