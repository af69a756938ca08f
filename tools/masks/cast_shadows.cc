#include "tools/masks/cast_shadows.h"

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

constexpr int kFewestPixels = 50;
constexpr double kSmoothingPixels = 2.0;
constexpr double kLowerPart = 0.25;  // of the mover's box
constexpr double kGround = 0.7;      // percentile
constexpr double kDark = 0.6;        // of the ground
constexpr float kTouchesPixels = 4.0F;

// The ground's brightness, a percentile over `near`; 0 if `near` is empty.
uint8_t Ground(const cv::Mat1b& brightness, const cv::Mat1b& near) {
  std::vector<uint8_t> values;
  for (int y = 0; y < near.rows; ++y) {
    for (int x = 0; x < near.cols; ++x) {
      if (near(y, x) != 0) values.push_back(brightness(y, x));
    }
  }
  return values.empty() ? uint8_t{0} : vision::QuantileInPlace(values, kGround);
}

// The connected parts of `dark` with a pixel of `touching`.
cv::Mat1b PartsThatTouch(const cv::Mat1b& dark, const cv::Mat1b& touching) {
  cv::Mat1i parts;
  const int count = cv::connectedComponents(dark, parts, 8, CV_32S);
  std::vector<uint8_t> touches(count, 0);
  for (int y = 0; y < dark.rows; ++y) {
    for (int x = 0; x < dark.cols; ++x) {
      if (dark(y, x) != 0 && touching(y, x) != 0) touches[parts(y, x)] = 255;
    }
  }
  cv::Mat1b result(dark.size());
  for (int y = 0; y < dark.rows; ++y) {
    for (int x = 0; x < dark.cols; ++x) result(y, x) = touches[parts(y, x)];
  }
  return result;
}

}  // namespace

cv::Mat1b FindCastShadows(const cv::Mat3b& picture, const cv::Mat1b& moving, int margin_pixels) {
  cv::Mat1b shadows(moving.size(), uint8_t{0});
  if (margin_pixels <= 0 || cv::countNonZero(moving) == 0) return shadows;
  cv::Mat grey;
  cv::Mat1b brightness;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, brightness, cv::Size(), kSmoothingPixels);
  cv::Mat1i movers, boxes;
  cv::Mat1d centres;
  const int count = cv::connectedComponentsWithStats(moving != 0, movers, boxes, centres, 8);
  const cv::Rect whole({0, 0}, moving.size());
  for (int mover = 1; mover < count; ++mover) {
    if (boxes(mover, cv::CC_STAT_AREA) < kFewestPixels) continue;
    const int bottom = boxes(mover, cv::CC_STAT_TOP) + boxes(mover, cv::CC_STAT_HEIGHT);
    const int foot = bottom - static_cast<int>(kLowerPart * boxes(mover, cv::CC_STAT_HEIGHT));
    const cv::Rect around = whole & cv::Rect(boxes(mover, cv::CC_STAT_LEFT) - margin_pixels, foot,
                                             boxes(mover, cv::CC_STAT_WIDTH) + 2 * margin_pixels,
                                             bottom - foot + margin_pixels);
    cv::Mat1f distance;
    cv::distanceTransform(movers(around) != mover, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    const cv::Mat1b near = (distance <= static_cast<double>(margin_pixels)) & (moving(around) == 0);
    const cv::Mat1b dark = near & (brightness(around) < kDark * Ground(brightness(around), near));
    shadows(around).setTo(255, PartsThatTouch(dark, distance <= kTouchesPixels));
  }
  return shadows;
}

}  // namespace egosieve::tools
