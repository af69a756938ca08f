#include "tools/masks/palette_png.h"

#include <png.h>

#include <array>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr int kLabels = 256;

// Bits 0, 3 and 6 of the label are the most significant bits of red; bits 1, 4, 7 those of green,
// and bits 2, 5 those of blue.
std::array<uint8_t, 3 * kLabels> VocColours() {
  std::array<uint8_t, 3 * kLabels> colours = {};
  for (int label = 0; label < kLabels; ++label) {
    for (int bit = 0; bit < 8; ++bit) {
      colours[3 * label + bit % 3] |= ((label >> bit) & 1) << (7 - bit / 3);
    }
  }
  return colours;
}

}  // namespace

absl::StatusOr<std::string> EncodePalettePng(const cv::Mat1b& labels) {
  static const std::array<uint8_t, 3 * kLabels> colours = VocColours();
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(labels.cols);
  image.height = static_cast<png_uint_32>(labels.rows);
  image.format = PNG_FORMAT_RGB_COLORMAP;
  image.colormap_entries = kLabels;
  image.flags = PNG_IMAGE_FLAG_FAST;
  const cv::Mat1b pixels = labels.isContinuous() ? labels : labels.clone();
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data, 0, colours.data()) ==
      0) {
    return absl::InternalError(absl::StrCat("the PNG encoder failed: ", image.message));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace egosieve::tools
