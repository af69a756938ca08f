// Corners after Shi & Tomasi (1994): local maxima of the smaller eigenvalue of the structure
// tensor,
//
//   lambda(x) = min eig sum_{window} grad I grad I^T,
//
// refined to a fraction of a pixel by a parabola through lambda along x and along y.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// grey: CV_8UC1. Row by row from the top, no two adjacent, at least `border` pixels inside; corners
// with lambda <= minimum_response are left out. `response` is lambda.
std::vector<cv::KeyPoint> DetectCorners(const cv::Mat& grey, float minimum_response, int border);

// Chooses features evenly over an image: the strongest feature of each cell of a grid, then the
// second of each, and so on, until `count` are chosen. Within a round stronger ones come first; of
// equal responses, the earlier. Returns them in their order.
std::vector<cv::KeyPoint> SpreadOverGrid(const std::vector<cv::KeyPoint>& features,
                                         cv::Size image_size, int cell_pixels, int64_t count);

}  // namespace egosieve::vision
