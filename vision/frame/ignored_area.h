// The area of the image that does not show the scene: the own vehicle (own_vehicle.h) or a user's
// mask.
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::vision {

// Whether the point (x, y) of an image of the size `image` is ignored: its nearest pixel of
// `ignored` is not 0. An empty mask or one of another size ignores nothing.
inline bool IsIgnored(const cv::Mat1b& ignored, cv::Size image, double x, double y) {
  if (ignored.empty() || ignored.size() != image) return false;
  const int column = cvRound(x), row = cvRound(y);
  return column >= 0 && row >= 0 && column < image.width && row < image.height &&
         ignored(row, column) != 0;
}

// The union of two masks: where one of them is not 0. An empty mask has no pixels.
inline cv::Mat1b United(const cv::Mat1b& a, const cv::Mat1b& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return a | b;
}

}  // namespace egosieve::vision
