// Decodes picture files to 8-bit BGR, by the conversions of vision/frame/frame_source.h.
#ifndef EGOSIEVE_VISION_FRAME_IMAGE_DECODING_H_
#define EGOSIEVE_VISION_FRAME_IMAGE_DECODING_H_

#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::vision {

struct DecodedImage {
  cv::Mat image;  // CV_8UC3
  bool is_grey = false;
};

// True for the file name extensions of pictures, in upper or lower case.
bool HasImageExtension(const std::string& path);

// Converts a picture of 1, 3 or 4 channels, with 8 or 16 bits or float values in [0, 1].
// InvalidArgument for other types, naming the type.
absl::StatusOr<DecodedImage> ConvertToBgr(const cv::Mat& picture);

// Errors of kernels/files/atomic_file.h if the file cannot be read. DataLoss, naming the file, if
// it is empty, truncated or not a picture. A PNG or JPEG without the end that its format requires
// counts as truncated.
absl::StatusOr<DecodedImage> DecodeImageFile(const std::string& path);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_IMAGE_DECODING_H_
