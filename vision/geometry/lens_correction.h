// The picture that a pinhole camera would have taken in the place of one with a lens (lens.h).
//
// It has the size of the camera's picture, the principal point in its middle, and the longest focal
// length with which it shows the middle of each side of the camera's picture. Corners may be cut.
//                                                                                           (LC1)
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/lens.h"

namespace egosieve::vision {

class LensCorrection {
 public:
  // size: of the camera's pictures. InvalidArgument if the distortion cannot be undone at the
  // middle of a side, if that is more than 75 degrees from the axis, and for a single row or column.
  static absl::StatusOr<LensCorrection> Create(const Lens& lens, cv::Size size);

  cv::Size size() const { return there_.size(); }
  double focal_pixels() const { return focal_; }  // of the pinhole picture
  // Whether no pixel moves by more than half a pixel.
  bool IsIdentity() const;

  // The pinhole picture; where it shows nothing of the camera's picture, that one's border.
  cv::Mat Correct(const cv::Mat& picture) const;
  // Of the pinhole picture: 255 where it shows nothing, or a place that is set in `mask`, else 0.
  // mask: of the camera's picture; empty: nothing is set.
  cv::Mat1b CorrectMask(const cv::Mat1b& mask) const;
  // From the pinhole picture to the camera's: a mask, by nearest pixels, and places.
  cv::Mat1b DistortMask(const cv::Mat1b& mask) const;
  cv::Point2d Distort(cv::Point2d place) const;

 private:
  LensCorrection(const Lens& lens, cv::Size size) : lens_(lens), there_(size) {}
  cv::Point2d Middle() const { return {0.5 * (size().width - 1), 0.5 * (size().height - 1)}; }
  // Rays (u, v, 1) through pixels of the camera's picture.
  std::vector<cv::Point2d> RaysThrough(const std::vector<cv::Point2d>& pixels) const;
  absl::Status ChooseFocal();
  void MakeMap();

  Lens lens_;
  double focal_ = 1.0;
  cv::Mat2f there_;  // by pixel of the pinhole picture, the place in the camera's
};

// The pinhole picture; the picture itself if there is no lens, or one of pictures of another size.
inline cv::Mat Corrected(const cv::Mat& picture, const LensCorrection* lens) {
  return lens != nullptr && lens->size() == picture.size() ? lens->Correct(picture) : picture;
}

}  // namespace egosieve::vision
