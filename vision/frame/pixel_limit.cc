#include "vision/frame/pixel_limit.h"

#include "absl/strings/str_format.h"

namespace egosieve::vision {
namespace {

int64_t BigEndian(std::string_view bytes) {
  int64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

// Signature, then the chunk IHDR: length, name, width, height.
absl::Status CheckPng(std::string_view bytes) {
  constexpr size_t kWidth = 16, kHeight = 20, kEnd = 24;
  if (bytes.size() < kEnd) return absl::OkStatus();
  return CheckPixels(BigEndian(bytes.substr(kWidth, 4)), BigEndian(bytes.substr(kHeight, 4)));
}

// Segments: 0xff, marker, two bytes of length, which include themselves. Segments of the frame
// header (SOF0 to SOF15 except DHT, JPG and DAC) hold precision, height and width.
absl::Status CheckJpeg(std::string_view bytes) {
  size_t place = 2;
  while (place + 9 <= bytes.size() && bytes[place] == '\xff') {
    const unsigned char marker = static_cast<unsigned char>(bytes[place + 1]);
    if (marker == 0xff) {  // padding
      ++place;
      continue;
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      return CheckPixels(BigEndian(bytes.substr(place + 7, 2)),
                         BigEndian(bytes.substr(place + 5, 2)));
    }
    place += 2 + static_cast<size_t>(BigEndian(bytes.substr(place + 2, 2)));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckPixels(int64_t width_pixels, int64_t height_pixels) {
  if (width_pixels <= 0 || height_pixels <= kMaximumPixels / width_pixels) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%d x %d pixels are more than the %d that are taken; make the picture smaller", width_pixels,
      height_pixels, kMaximumPixels));
}

absl::Status CheckPixelsOfFile(std::string_view bytes) {
  if (bytes.substr(0, 4) == "\x89PNG") return CheckPng(bytes);
  if (bytes.substr(0, 2) == "\xff\xd8") return CheckJpeg(bytes);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
