#include "vision/segmentation/frame_calibration.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "gp/calibration/leave_one_out.h"
#include "kernels/base/status_macros.h"
#include "vision/segmentation/rows.h"

namespace egosieve::vision {
namespace {

constexpr double kLeastShare = 0.002;  // of movers, and of the static scene

}  // namespace

absl::StatusOr<gp::SquashParameters> FitSquashToFrame(const gp::Posterior& posterior,
                                                      kernels::ConstMatrixView<float> inputs,
                                                      absl::Span<const double> labels,
                                                      absl::Span<const int64_t> left,
                                                      int64_t sample_size, uint64_t seed) {
  std::vector<double> targets;
  targets.reserve(left.size());
  for (const int64_t row : left) targets.push_back(2.0 * labels[row] - 1.0);
  const std::vector<int64_t> rows =
      Gather<int64_t>(left, gp::StratifiedSample(targets, sample_size, 0.5, seed));
  const std::vector<float> queries = GatherRows(inputs, rows);
  std::vector<float> mean(rows.size()), variance(rows.size());
  kernels::PosteriorOutputs outputs;
  outputs.mean = mean.data();
  outputs.variance = variance.data();
  EGOSIEVE_RETURN_IF_ERROR(
      posterior
          .Evaluate(kernels::ConstMatrixView<float>(queries.data(),
                                                    static_cast<int64_t>(rows.size()), inputs.cols),
                    outputs)
          .status());
  const double sum = std::accumulate(labels.begin(), labels.end(), 0.0);
  const double share =
      std::clamp(sum / static_cast<double>(labels.size()), kLeastShare, 1.0 - kLeastShare);
  return gp::FitSquash(std::vector<double>(mean.begin(), mean.end()),
                       std::vector<double>(variance.begin(), variance.end()), Gather(labels, rows),
                       posterior.squash(), share);
}

}  // namespace egosieve::vision
