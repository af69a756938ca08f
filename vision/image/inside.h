// Whether a position lies in a picture, whose pixels' centres are at whole numbers.
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::vision {

// Within the centres of the outermost pixels, which are included. False for NaN.
inline bool IsInside(double x, double y, cv::Size picture) {
  return x >= 0 && y >= 0 && x <= picture.width - 1 && y <= picture.height - 1;
}

}  // namespace egosieve::vision
