#include "tools/masks/stored_picture.h"

#include <opencv2/imgcodecs.hpp>

#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

// EXIF's orientations 5 to 8 are 1 to 4 behind a transposition.
constexpr int kNoFlip = 2;
constexpr int kFlips[] = {kNoFlip, 1, -1, 0};  // as cv::flip names them

cv::Mat Flipped(const cv::Mat& image, int orientation) {
  const int flip = kFlips[(orientation - 1) % 4];
  if (flip == kNoFlip) return image;
  cv::Mat flipped;
  cv::flip(image, flipped, flip);
  return flipped;
}

cv::Mat Transposed(const cv::Mat& image, int orientation) {
  return orientation > 4 ? cv::Mat(image.t()) : image;
}

}  // namespace

absl::StatusOr<StoredPicture> ReadStoredPicture(const std::string& path) {
  StoredPicture picture;
  EGOSIEVE_ASSIGN_OR_RETURN(picture.pixels,
                            ReadImage(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat upright, ReadImage(path, cv::IMREAD_COLOR));
  // OpenCV does not report the orientation by which it turned a picture.
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const cv::Mat turned = Flipped(Transposed(picture.pixels, orientation), orientation);
    if (turned.size() == upright.size() && cv::norm(turned, upright, cv::NORM_INF) == 0.0) {
      picture.orientation = orientation;
      return picture;
    }
  }
  return picture;
}

cv::Mat TurnBack(const cv::Mat& upright, int orientation) {
  return Transposed(Flipped(upright, orientation), orientation);
}

}  // namespace egosieve::tools
