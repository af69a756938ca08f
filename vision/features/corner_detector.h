// Corners after Shi & Tomasi (1994): local maxima of the smaller eigenvalue of the structure
// tensor,
//
//   lambda(x) = min eig sum_{window} grad I grad I^T,
//
// refined to a fraction of a pixel by a parabola through lambda along x and along y.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct Corner {
  cv::Point2f position;
  float response = 0.0F;  // lambda
};

// grey: CV_8UC1. Row by row from the top, no two adjacent, at least `border` pixels inside; corners
// with lambda <= minimum_response are left out.
std::vector<Corner> DetectCorners(const cv::Mat& grey, float minimum_response, int border);

}  // namespace egosieve::vision
