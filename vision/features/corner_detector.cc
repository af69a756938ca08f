#include "vision/features/corner_detector.h"

#include <algorithm>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "vision/image/cell_grid.h"

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

std::vector<cv::KeyPoint> DetectCorners(const cv::Mat& grey, float minimum_response, int border) {
  std::vector<cv::KeyPoint> corners;
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
      corners.emplace_back(cv::Point2f(x + dx, y + dy), 1.0F, -1.0F, row[x]);
    }
  }
  return corners;
}

std::vector<cv::KeyPoint> SpreadOverGrid(const std::vector<cv::KeyPoint>& features,
                                         cv::Size image_size, int cell_pixels, int64_t count) {
  const int64_t total = static_cast<int64_t>(features.size());
  if (total <= count) return features;
  std::vector<int64_t> order(total);
  std::iota(order.begin(), order.end(), int64_t{0});
  const auto stronger = [&](int64_t a, int64_t b) {
    return features[a].response != features[b].response
               ? features[a].response > features[b].response
               : a < b;
  };
  std::sort(order.begin(), order.end(), stronger);

  const auto cells = CellsUpTo(image_size.width, image_size.height, cell_pixels);
  std::vector<int32_t> taken(cells.size(), 0);
  std::vector<int32_t> round(total);
  for (const int64_t i : order) {
    round[i] = taken[cells.IndexOf(features[i].pt.x, features[i].pt.y)]++;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return round[a] < round[b]; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  std::vector<cv::KeyPoint> chosen;
  for (const int64_t i : order) chosen.push_back(features[i]);
  return chosen;
}

}  // namespace egosieve::vision
