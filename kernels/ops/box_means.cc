#include "kernels/ops/box_means.h"

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_image.h"
#include "kernels/reference/image.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

// Limit that keeps sums of 8-bit values over a window below 2^31.
constexpr int kMaxWindowPixels = 2001;

absl::Status CheckImage(const ImageView& image) {
  if (image.width < 1 || image.height < 1 || image.data == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrFormat("image of %d x %d pixels%s; both sides must be at least 1", image.width,
                        image.height, image.data == nullptr ? " without data" : ""));
  }
  if (image.channels != 1 && image.channels != 3) {
    return absl::InvalidArgumentError(
        absl::StrFormat("image.channels = %d; it must be 1 or 3", image.channels));
  }
  if (image.stride_bytes < static_cast<ptrdiff_t>(image.width) * image.channels) {
    return absl::InvalidArgumentError(
        absl::StrFormat("image.stride_bytes = %d; a row of %d pixels has %d bytes",
                        image.stride_bytes, image.width, image.width * image.channels));
  }
  return absl::OkStatus();
}

absl::Status CheckPoints(const ImageView& image, ConstMatrixView<double> points) {
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("points", points, points.rows, 2));
  for (int64_t i = 0; i < points.rows; ++i) {
    const double x = points(i, 0);
    const double y = points(i, 1);
    if (!(x >= -0.5 && x <= image.width - 0.5 && y >= -0.5 && y <= image.height - 0.5)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("points row %d = (%g, %g) is outside the image of %d x %d", i, x, y,
                          image.width, image.height));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status BoxMeanOptions::Validate() const {
  if (window_pixels < 1 || window_pixels % 2 == 0 || window_pixels > kMaxWindowPixels) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "window_pixels = %d; it must be odd, from 1 to %d", window_pixels, kMaxWindowPixels));
  }
  return absl::OkStatus();
}

absl::Status BoxMeansOnGrid(Context& context, const ImageView& image, const ImageGrid& grid,
                            const BoxMeanOptions& options, MatrixView<float> out) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckImage(image));
  EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
  if (grid.width != image.width || grid.height != image.height) {
    return absl::InvalidArgumentError(
        absl::StrFormat("grid is for %d x %d pixels, the image has %d x %d", grid.width,
                        grid.height, image.width, image.height));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, grid.size(), kBoxMeanColumns));
  if (context.is_reference()) {
    reference::BoxMeansOnGrid(image, grid, options.window_pixels, out);
    return absl::OkStatus();
  }
  return opencl::BoxMeansOnGrid(context, image, grid, options.window_pixels, out);
}

absl::Status BoxMeansAt(Context& context, const ImageView& image, ConstMatrixView<double> points,
                        const BoxMeanOptions& options, MatrixView<float> out) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckImage(image));
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(image, points));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, points.rows, kBoxMeanColumns));
  if (context.is_reference()) {
    reference::BoxMeansAt(image, points, options.window_pixels, out);
    return absl::OkStatus();
  }
  return opencl::BoxMeansAt(context, image, points, options.window_pixels, out);
}

}  // namespace egosieve::kernels
