// Picture files to 8-bit BGR, by the conversions of vision/frame/frame_source.h.
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

// True for the file name extensions of pictures, whatever their case.
bool HasImageExtension(const std::string& path);

// Any picture of 1, 3 or 4 channels and 8 or 16 bits, or of float values in [0, 1]. InvalidArgument
// for other types, naming the type.
absl::StatusOr<DecodedImage> ConvertToBgr(const cv::Mat& picture);

// Errors of kernels/files/atomic_file.h where it cannot be read; DataLoss, naming the file, where
// it is empty, cut short or no picture. A PNG or JPEG that does not end as the format demands
// counts as cut short.
absl::StatusOr<DecodedImage> DecodeImageFile(const std::string& path);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_IMAGE_DECODING_H_
