// The range of levels that pictures use, where it is less than half of all. What differs in dark or
// hazy pictures differs by fewer levels than in others, so levels are compared with the range.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct TonalRange {
  // The 0.001 quantile of the darkest and the 0.999 quantile of the brightest channel, of 255; all
  // levels if these are half of them or more.
  double low = 0.0, high = 255.0;

  // At least kFewestLevels, for blank pictures.
  double Levels() const;
};

// Of every kPixelStep-th pixel along both axes.
TonalRange TonalRangeOf(const std::vector<cv::Mat3b>& pictures);

// The picture with the range's ends at 0 and 255.
cv::Mat3b Stretched(const cv::Mat3b& picture, const TonalRange& range);

}  // namespace egosieve::vision
