// The part of the image that is not the world: the own vehicle (own_vehicle.h), a user's mask.
#ifndef EGOSIEVE_VISION_FRAME_IGNORED_AREA_H_
#define EGOSIEVE_VISION_FRAME_IGNORED_AREA_H_

#include <opencv2/core.hpp>

namespace egosieve::vision {

// Whether a place of an image of the size `image` is ignored: nearest pixel of `ignored` not 0. A
// mask of another size, an empty one among them, ignores nothing.
inline bool IsIgnored(const cv::Mat1b& ignored, cv::Size image, double x, double y) {
  if (ignored.empty() || ignored.size() != image) return false;
  const int column = cvRound(x), row = cvRound(y);
  return column >= 0 && row >= 0 && column < image.width && row < image.height &&
         ignored(row, column) != 0;
}

// Where one of two masks is not 0; an empty one counts for nothing.
inline cv::Mat1b United(const cv::Mat1b& a, const cv::Mat1b& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return a | b;
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_IGNORED_AREA_H_
