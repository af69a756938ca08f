#include "tools/masks/stored_picture.h"

#include <opencv2/imgcodecs.hpp>

#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

cv::Mat Turn(const cv::Mat& stored, int orientation) {
  cv::Mat turned;
  switch (orientation) {
    case 2:
      cv::flip(stored, turned, 1);
      return turned;
    case 3:
      cv::rotate(stored, turned, cv::ROTATE_180);
      return turned;
    case 4:
      cv::flip(stored, turned, 0);
      return turned;
    case 5:
      cv::transpose(stored, turned);
      return turned;
    case 6:
      cv::rotate(stored, turned, cv::ROTATE_90_CLOCKWISE);
      return turned;
    case 7:
      cv::transpose(stored, turned);
      cv::rotate(turned, turned, cv::ROTATE_180);
      return turned;
    case 8:
      cv::rotate(stored, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
      return turned;
    default:
      return stored;
  }
}

}  // namespace

absl::StatusOr<StoredPicture> ReadStoredPicture(const std::string& path) {
  StoredPicture picture;
  EGOSIEVE_ASSIGN_OR_RETURN(picture.pixels,
                            ReadImage(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat upright, ReadImage(path, cv::IMREAD_COLOR));
  // OpenCV does not report the orientation by which it turned a picture.
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const cv::Mat turned = Turn(picture.pixels, orientation);
    if (turned.size() == upright.size() && cv::norm(turned, upright, cv::NORM_INF) == 0.0) {
      picture.orientation = orientation;
      return picture;
    }
  }
  return picture;
}

cv::Mat TurnBack(const cv::Mat& upright, int orientation) {
  if (orientation == 6) return Turn(upright, 8);
  if (orientation == 8) return Turn(upright, 6);
  return Turn(upright, orientation);  // the other orientations are their own inverses
}

}  // namespace egosieve::tools
