#include "tools/refine/full_maps.h"

#include "absl/strings/str_format.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/status_macros.h"
#include "vision/image/grid_interpolation.h"

namespace egosieve::tools {

absl::Status ClassThresholds::Validate() const {
  if (!(static_below >= 0.0 && static_below <= dynamic_above && dynamic_above <= 1.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--static_below=%g and --dynamic_above=%g; both must lie in [0, 1], the first not above "
        "the second",
        static_below, dynamic_above));
  }
  return absl::OkStatus();
}

absl::StatusOr<cv::Mat1f> InterpolateMap(const vision::ImageGrid& grid, const cv::Mat1f& values) {
  cv::Mat1f full(grid.height, grid.width);
  const kernels::ConstMatrixView<float> in(values.ptr<float>(), values.rows, values.cols,
                                           static_cast<int64_t>(values.step1()));
  const kernels::MatrixView<float> out(full.ptr<float>(), full.rows, full.cols,
                                       static_cast<int64_t>(full.step1()));
  EGOSIEVE_RETURN_IF_ERROR(vision::GridInterpolation(grid, in, out));
  return full;
}

cv::Mat1b ClassifyMap(const cv::Mat1f& probability, const ClassThresholds& thresholds) {
  cv::Mat1b classes(probability.size(), uint8_t{128});
  classes.setTo(0, probability < thresholds.static_below);
  classes.setTo(255, probability > thresholds.dynamic_above);
  return classes;
}

}  // namespace egosieve::tools
