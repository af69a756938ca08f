// The range of levels that pictures use. What differs in dark or hazy pictures differs by fewer
// levels than in others. Pictures that use less than half of the levels count as if they used half.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// Edges of kEdgeLevels of edge_refinement.cc are at least one level with it.
inline constexpr double kMostGain = 5.0;

struct TonalRange {
  // The 0.001 quantile of the darkest and the 0.999 quantile of the brightest channel, of 255.
  double low = 0.0, high = 255.0;

  // What makes the range half of all levels; from 1 to kMostGain.
  double Gain() const;
};

// Of every kPixelStep-th pixel along both axes.
TonalRange TonalRangeOf(const std::vector<cv::Mat3b>& pictures);

// The picture with the range from 0 to half of all levels, where its gain is above 1.
cv::Mat3b Stretched(const cv::Mat3b& picture, const TonalRange& range);

}  // namespace egosieve::vision
