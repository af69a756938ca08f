#include "vision/features/corner_detector.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr int kWindow = 3;
constexpr int kSobel = 3;

// The position of the maximum of the parabola through (-1, before), (0, centre), (1, after).
float ParabolaPeak(float before, float centre, float after) {
  const float curvature = before - 2.0F * centre + after;
  if (!(curvature < 0.0F)) return 0.0F;
  return std::clamp(0.5F * (before - after) / curvature, -0.5F, 0.5F);
}

// Of equal neighbours only the first in row order is a maximum.
bool IsMaximum(const float* above, const float* row, const float* below, int x) {
  const float v = row[x];
  return v > above[x - 1] && v > above[x] && v > above[x + 1] && v > row[x - 1] &&
         v >= row[x + 1] && v >= below[x - 1] && v >= below[x] && v >= below[x + 1];
}

}  // namespace

std::vector<Corner> DetectCorners(const cv::Mat& grey, float minimum_response, int border) {
  std::vector<Corner> corners;
  const int margin = std::max(border, 1);
  if (grey.cols <= 2 * margin || grey.rows <= 2 * margin) return corners;
  cv::Mat response;
  cv::cornerMinEigenVal(grey, response, kWindow, kSobel);
  for (int y = margin; y < response.rows - margin; ++y) {
    const float* above = response.ptr<float>(y - 1);
    const float* row = response.ptr<float>(y);
    const float* below = response.ptr<float>(y + 1);
    for (int x = margin; x < response.cols - margin; ++x) {
      if (!(row[x] > minimum_response) || !IsMaximum(above, row, below, x)) continue;
      const float dx = ParabolaPeak(row[x - 1], row[x], row[x + 1]);
      const float dy = ParabolaPeak(above[x], row[x], below[x]);
      corners.push_back({cv::Point2f(x + dx, y + dy), row[x]});
    }
  }
  return corners;
}

}  // namespace egosieve::vision
