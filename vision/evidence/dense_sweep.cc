#include "vision/evidence/dense_sweep.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/plane_sweep.h"
#include "vision/evidence/epipolar_line.h"
#include "vision/evidence/patch.h"
#include "vision/evidence/photometric_support.h"

namespace egosieve::vision {
namespace {

constexpr double kMostScale = 4.0;  // nearer points are not swept

absl::Status Check(const DenseSweepPair& pair, const kernels::ImageGrid& grid) {
  if (pair.before.empty() || pair.before.type() != CV_8UC1 || pair.now.type() != CV_8UC1 ||
      pair.before.size() != pair.now.size()) {
    return absl::InvalidArgumentError("before and now must be CV_8UC1 of one size");
  }
  if (pair.flow.type() != CV_32FC2 || pair.flow.rows != grid.rows() ||
      pair.flow.cols != grid.columns()) {
    return absl::InvalidArgumentError(absl::StrCat("flow must be CV_32FC2 of ", grid.rows(),
                                                   " rows and ", grid.columns(), " columns"));
  }
  return kernels::CheckOptions({
      {"most_inverse_depth", pair.most_inverse_depth,
       kernels::IsNotNegative(pair.most_inverse_depth), "not be negative"},
      {"noise_levels", pair.noise_levels, kernels::IsPositive(pair.noise_levels), "be positive"},
      {"place_pixels", pair.place_pixels, kernels::IsNotNegative(pair.place_pixels),
       "not be negative"},
  });
}

kernels::ImageView ViewOf(const cv::Mat& grey) {
  return {grey.data, grey.cols, grey.rows, 1, static_cast<ptrdiff_t>(grey.step[0])};
}

kernels::PlaneSweepInputs InputsOf(const DenseSweepPair& pair, const DenseSweepOptions& options,
                                   const kernels::ImageGrid& grid) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d k = pair.camera.Matrix();
  kernels::PlaneSweepInputs inputs;
  inputs.first = ViewOf(pair.before);
  inputs.second = ViewOf(pair.now);
  inputs.grid = grid;
  Eigen::Map<RowMajor>(inputs.homography.data()) = k * pair.rotation * k.inverse();
  Eigen::Map<Eigen::Vector3d>(inputs.epipole.data()) = k * pair.translation;
  inputs.steps = SweepStepsOf(pair, options);
  inputs.patch_radius = kPatchRadius;
  return inputs;
}

// l of a place from its row of the sweep's results. A cost that is NaN gives 0.
double LogRatioOf(const float* costs, bool is_lost, const DenseSweepPair& pair) {
  const double texture = kLeastTexture * pair.noise_levels;
  const double still = costs[kernels::kStaticCost], energy = costs[kernels::kEnergy];
  const double gradient = costs[kernels::kGradient];
  if (!(energy >= kPatchPixels * texture * texture)) return 0.0;
  if (is_lost && !(costs[kernels::kLeastGradient] >= kLeastCorner * gradient)) return 0.0;
  const double found = is_lost ? kMostChange * energy : costs[kernels::kFlowCost];
  if (std::isnan(still) || std::isnan(found)) return 0.0;
  return GreyLogRatio(still, found, pair.noise_levels,
                      pair.place_pixels * pair.place_pixels * gradient);
}

}  // namespace

absl::Status DenseSweepOptions::Validate() const {
  return kernels::CheckOptions({
      {"stride", stride, stride >= 1, "be at least 1"},
      {"step_pixels", step_pixels, kernels::IsPositive(step_pixels), "be positive"},
      {"most_steps", most_steps, most_steps >= 1, "be at least 1"},
  });
}

std::vector<kernels::SweepStep> SweepStepsOf(const DenseSweepPair& pair,
                                             const DenseSweepOptions& options) {
  const double forward = pair.translation(2);
  double nearest = pair.most_inverse_depth;
  if (forward < 0.0) nearest = std::min(nearest, (1.0 / kMostScale - 1.0) / forward);
  EpipolarLine longest;
  double most = 0.0;  // s
  for (const int x : {0, pair.before.cols - 1}) {
    for (const int y : {0, pair.before.rows - 1}) {
      const EpipolarLine line = LineOf(pair.camera, pair.rotation, pair.translation, x, y);
      const Eigen::Vector3d end = line.ray + nearest * pair.translation;
      if (!line.valid || !(end(2) > 0.0)) continue;
      const double along = line.Along(pair.camera.Project(end));
      if (!(along > most)) continue;
      most = along;
      longest = line;
    }
  }
  const double wanted = std::ceil(most / options.step_pixels) + 1.0;
  const int count = static_cast<int>(std::min<double>(wanted, options.most_steps));
  std::vector<kernels::SweepStep> steps = {{}};
  for (int j = 1; j < count; ++j) {
    const double r = longest.InverseDepth(most * j / (count - 1));
    const double scale = 1.0 / (1.0 + r * forward);
    steps.push_back({static_cast<float>(r),
                     std::abs(scale - 1.0) < kLeastScaling ? 1.0f : static_cast<float>(scale)});
  }
  return steps;
}

absl::StatusOr<cv::Mat> DenseSweepLogRatios(kernels::Context& context, const DenseSweepPair& pair,
                                            const DenseSweepOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  const kernels::ImageGrid grid = {pair.before.cols, pair.before.rows, options.stride};
  EGOSIEVE_RETURN_IF_ERROR(Check(pair, grid));
  const cv::Mat flow = pair.flow.isContinuous() ? pair.flow : pair.flow.clone();
  kernels::PlaneSweepInputs inputs = InputsOf(pair, options, grid);
  inputs.flow = {flow.ptr<float>(), grid.size(), 2};
  std::vector<float> costs(grid.size() * kernels::kSweepColumns);
  EGOSIEVE_RETURN_IF_ERROR(
      kernels::PlaneSweep(context, inputs, {costs.data(), grid.size(), kernels::kSweepColumns}));
  cv::Mat ratios(grid.rows(), grid.columns(), CV_32FC1);
  for (int64_t i = 0; i < grid.size(); ++i) {
    const bool is_lost = std::isnan(inputs.flow(i, 0)) || std::isnan(inputs.flow(i, 1));
    ratios.ptr<float>()[i] =
        static_cast<float>(LogRatioOf(&costs[i * kernels::kSweepColumns], is_lost, pair));
  }
  return ratios;
}

}  // namespace egosieve::vision
