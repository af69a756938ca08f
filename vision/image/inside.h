// Whether a position lies in a picture, whose pixels' centres are at whole numbers.
#ifndef EGOSIEVE_VISION_IMAGE_INSIDE_H_
#define EGOSIEVE_VISION_IMAGE_INSIDE_H_

#include <opencv2/core.hpp>

namespace egosieve::vision {

// Within the centres of the outermost pixels, which are included. False for NaN.
inline bool IsInside(double x, double y, cv::Size picture) {
  return x >= 0 && y >= 0 && x <= picture.width - 1 && y <= picture.height - 1;
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_IMAGE_INSIDE_H_
