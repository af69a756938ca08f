// Maps as 16-bit grey PNG files.
//
//   pixel = round(65535 min(value / full_scale, 1)),   value >= 0
//
// A value is recovered within full_scale / 131070, unless it saturated.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

struct EncodedMap {
  std::string png;
  int64_t saturated = 0;  // values above full_scale
};

// Pixels of values that are not negative, and values of pixels.
cv::Mat1w MapPixels(const cv::Mat1f& values, double full_scale);
cv::Mat1f MapValues(const cv::Mat1w& pixels, double full_scale);

// InvalidArgument, naming the pixel, if a value is negative or not a number.
absl::StatusOr<EncodedMap> EncodeMap(const cv::Mat1f& values, double full_scale);

// Reads an image file with OpenCV's `flags` (cv::IMREAD_*). DataLoss, naming `path`, if it is not
// an image; errors of kernels/files/atomic_file.h.
absl::StatusOr<cv::Mat> ReadImage(const std::string& path, int flags);

// DataLoss, naming `path`, unless the file is a 16-bit grey PNG of the expected size; NotFound.
absl::StatusOr<cv::Mat1f> ReadMap(const std::string& path, cv::Size expected, double full_scale);

// Any 8-bit image as PNG bytes.
absl::StatusOr<std::string> EncodePng(const cv::Mat& image);
absl::Status WritePng(const std::string& path, const cv::Mat& image);

}  // namespace egosieve::tools
