#include "vision/masks/tonal_range.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace egosieve::vision {
namespace {

constexpr int kPixelStep = 4;  // pixels
constexpr double kOutsideRange = 0.001;
constexpr double kFewestLevels = 16.0;
constexpr int kHalf = 128;  // levels

}  // namespace

double TonalRange::Levels() const { return std::max(kFewestLevels, high - low); }

TonalRange TonalRangeOf(const std::vector<cv::Mat3b>& pictures) {
  std::array<int64_t, 256> darkest{}, brightest{};
  int64_t count = 0;
  for (const cv::Mat3b& picture : pictures) {
    for (int y = 0; y < picture.rows; y += kPixelStep) {
      for (int x = 0; x < picture.cols; x += kPixelStep) {
        const cv::Vec3b& colour = picture(y, x);
        ++darkest[std::min({colour[0], colour[1], colour[2]})];
        ++brightest[std::max({colour[0], colour[1], colour[2]})];
        ++count;
      }
    }
  }
  const auto outside = static_cast<int64_t>(kOutsideRange * static_cast<double>(count));
  int low = 0, high = 255;
  for (int64_t below = darkest[0]; below <= outside && low < 255;) below += darkest[++low];
  for (int64_t above = brightest[255]; above <= outside && high > low;) above += brightest[--high];
  if (high - low >= kHalf) return {};
  return {static_cast<double>(low), static_cast<double>(high)};
}

cv::Mat3b Stretched(const cv::Mat3b& picture, const TonalRange& range) {
  const double gain = 255.0 / range.Levels();
  cv::Mat3b stretched;
  picture.convertTo(stretched, CV_8U, gain, -gain * range.low);
  return stretched;
}

}  // namespace egosieve::vision
