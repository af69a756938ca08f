// The largest picture that is accepted: 2^27 pixels, four times those of 8K video (7680x4320) and
// those of 15360x8640. A few kilobytes of PNG can contain a picture of gigabytes, which would fill
// the memory or take hours.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"

namespace egosieve::vision {

inline constexpr int64_t kMaximumPixels = int64_t{1} << 27;

// InvalidArgument, with both sizes and the remedy, for more than kMaximumPixels.
absl::Status CheckPixels(int64_t width_pixels, int64_t height_pixels);

// The same for a PNG or JPEG file from its header, before anything is decoded. OK for other formats
// and for damaged files, for which the decoder returns the error.
absl::Status CheckPixelsOfFile(std::string_view bytes);

}  // namespace egosieve::vision
