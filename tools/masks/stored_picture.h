// Pictures as stored in their files. The frames of a run are turned upright according to EXIF.
// COLMAP, PIL and stb, by which other programs read pictures, do not turn them, and need masks that
// match the stored pixels.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct StoredPicture {
  cv::Mat3b pixels;
  int orientation = 1;  // EXIF's, 1 to 8, by which `pixels` are turned upright
};

// Errors of ReadImage.
absl::StatusOr<StoredPicture> ReadStoredPicture(const std::string& path);

// The pixels of an upright picture as stored in a file with that orientation.
cv::Mat TurnBack(const cv::Mat& upright, int orientation);

}  // namespace egosieve::tools
