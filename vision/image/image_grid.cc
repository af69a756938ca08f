#include "vision/image/image_grid.h"

#include "absl/strings/str_format.h"

namespace egosieve::vision {

absl::Status ImageGrid::Validate() const {
  if (width < 1 || height < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("image of %d x %d pixels; both sides must be at least 1", width, height));
  }
  if (stride < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("stride = %d; it must be at least 1", stride));
  }
  return absl::OkStatus();
}

PixelNormalization NormalizationForImage(int width, int height) {
  const double extent = std::max(width, height) - 1;
  if (!(extent > 0.0)) {
    return PixelNormalization{0.0, 0.0, 0.0};
  }
  return PixelNormalization{2.0 / extent, -(width - 1) / extent, -(height - 1) / extent};
}

}  // namespace egosieve::vision
