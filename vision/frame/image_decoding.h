// Decodes picture files to 8-bit BGR, by the conversions of vision/frame/frame_source.h.
//
// Values of 16 bits or float of which a drive uses a small part (counts of a thermal camera, 12
// bits of a machine camera) are stretched, by one range for the whole drive:
//
//   v' = 255 (v - low) / (high - low),  clamped to 0 .. 255
//
// low and high are the .001 and .999 quantiles of sampled values.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::vision {

struct DecodedImage {
  cv::Mat image;  // CV_8UC3
  bool is_grey = false;
};

struct ValueRange {
  double low = 0.0, high = 0.0;  // low < high
};

// The largest picture that is accepted: four times 8K video (7680x4320), or 15360x8640. A few
// kilobytes of PNG can contain a picture of gigabytes, which would fill the memory or take hours.
inline constexpr int64_t kMaximumPixels = int64_t{1} << 27;

// InvalidArgument, with both sizes and the remedy, for more than kMaximumPixels.
absl::Status CheckPixels(int64_t width_pixels, int64_t height_pixels);

// A file name's extension in lower case: ".png".
std::string ExtensionOf(const std::string& path);

// True for the file name extensions of pictures, in upper or lower case.
bool HasImageExtension(const std::string& path);

// "HEIC" for a file name extension of pictures that are not read; empty for all others.
std::string UnreadPictureKind(const std::string& path);

// Converts a picture of 1, 3 or 4 channels, with 8 or 16 bits or float values in [0, 1]; with
// `range`, 16 bits and floats are stretched. InvalidArgument for other types, naming the type.
absl::StatusOr<DecodedImage> ConvertToBgr(const cv::Mat& picture,
                                          const std::optional<ValueRange>& range = {});

// Errors of kernels/files/atomic_file.h if the file cannot be read. DataLoss, naming the file, if
// it is empty, damaged, cut short or not a picture.
absl::StatusOr<DecodedImage> DecodeImageFile(const std::string& path,
                                             const std::optional<ValueRange>& range = {});

// The range by which the pictures of a drive are to be stretched: of values of up to 32 of them,
// evenly spaced. None if the first readable one has 8 bits, if the values use half of the format's
// range or more, if they are bytes in 16 bits (257 v), or if they are all equal. Damaged pictures
// are passed over. Errors: as of DecodeImageFile, those of the machine alone.
absl::StatusOr<std::optional<ValueRange>> RangeOfDrive(const std::vector<std::string>& paths);

}  // namespace egosieve::vision
