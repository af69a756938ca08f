#include "vision/masks/tonal_range.h"

#include <algorithm>
#include <cstddef>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int kPixelStep = 4;  // pixels
constexpr double kTail = 0.001;
constexpr double kHalf = 127.5;  // levels

}  // namespace

double TonalRange::Gain() const {
  return high > low ? std::clamp(kHalf / (high - low), 1.0, kMostGain) : kMostGain;
}

TonalRange TonalRangeOf(const std::vector<cv::Mat3b>& pictures) {
  std::vector<uchar> darkest, brightest;
  for (const cv::Mat3b& picture : pictures) {
    for (int y = 0; y < picture.rows; y += kPixelStep) {
      for (int x = 0; x < picture.cols; x += kPixelStep) {
        const auto [low, high] =
            std::minmax({picture(y, x)[0], picture(y, x)[1], picture(y, x)[2]});
        darkest.push_back(low);
        brightest.push_back(high);
      }
    }
  }
  if (darkest.empty()) return {};
  return {static_cast<double>(QuantileInPlace(darkest, kTail)),
          static_cast<double>(QuantileInPlace(brightest, 1.0 - kTail))};
}

cv::Mat3b Stretched(const cv::Mat3b& picture, const TonalRange& range) {
  const double gain = range.Gain();
  if (gain == 1.0) return picture;
  cv::Mat3b stretched;
  picture.convertTo(stretched, CV_8U, gain, -gain * range.low);
  return stretched;
}

}  // namespace egosieve::vision
