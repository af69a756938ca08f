#include "vision/synthetic/own_vehicle.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

constexpr int kPatches = 7;

double BonnetTop(const OwnVehicleStyle& style, cv::Size size, int x) {  // (SO1)
  const double s = 2.0 * x / std::max(size.width - 1, 1) - 1.0;
  return size.height * (1.0 - style.bonnet * (1.0 - s * s / 3.0));
}

bool InBracket(cv::Size size, double x, double y) {  // (SO2)
  const double u = x / size.width, v = y / size.height;
  return u > 0.80 && v < 0.74 && v > 0.68 - 1.1 * (u - 0.80);
}

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

std::string StampText(double seconds) {
  const int second = static_cast<int>(std::floor(seconds));
  return absl::StrFormat("2024-05-03 14:%02d:%02d", second / 60 % 60, second % 60);
}

cv::Mat DrawReflection(const OwnVehicleStyle& style, cv::Size size) {  // (SO3)
  cv::Mat patches(size, CV_32FC1, cv::Scalar(0));
  for (int k = 0; k < kPatches; ++k) {
    const uint32_t h = Hash(style.seed + 7, k);
    const auto place = [&](int item) { return Unit(Hash(h + static_cast<uint32_t>(item))); };
    const cv::Point2f centre(size.width * place(1), size.height * (0.35f + 0.5f * place(2)));
    const cv::Size2f extent(size.width * (0.03f + 0.12f * place(3)),
                            size.height * (0.03f + 0.14f * place(4)));
    cv::Point2f corners[4];
    cv::RotatedRect(centre, extent, 60.0f * (place(5) - 0.5f)).points(corners);
    const std::vector<cv::Point> outline(corners, corners + 4);
    cv::fillConvexPoly(patches, outline, cv::Scalar(0.35 + 0.6 * place(6)), cv::LINE_8);
  }
  cv::blur(patches, patches, cv::Size(5, 5));
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float haze = 0.12f * (1.0f + FractalNoise(static_cast<float>(x) / size.width,
                                                      static_cast<float>(y) / size.width,
                                                      style.seed + 11, 0.002f, {0.25f, 5, 0.6f}));
      float& m = patches.at<float>(y, x);
      m = Clamp01(m + haze);
    }
  }
  return patches;
}

}  // namespace

OwnVehicle::OwnVehicle(const OwnVehicleStyle& style, cv::Size size)
    : style_(style),
      size_(size),
      scale_(size.height / 720.0),
      thickness_(std::max(1, size.height / 360)),
      mask_(cv::Mat::zeros(size, CV_8UC1)) {
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool own = y >= BonnetTop(style, size, x) || InBracket(size, x, y);
      mask_.at<uint8_t>(y, x) = own ? 255 : 0;
    }
  }
  const cv::Size text = cv::getTextSize(StampText(0.0), kFont, scale_, thickness_, nullptr);
  stamp_ = cv::Rect(text.height / 2, text.height / 2, text.width + 6, 2 * text.height) &
           cv::Rect({}, size);
  mask_(stamp_).setTo(255);
  reflection_ = DrawReflection(style, size);
}

void OwnVehicle::Cover(cv::Mat* radiance) const {
  const float strength = static_cast<float>(style_.reflection);
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      auto& pixel = radiance->at<cv::Vec3f>(y, x);
      if (InBracket(size_, x, y)) {
        pixel = {0.012f, 0.012f, 0.014f};
        continue;
      }
      const float below = static_cast<float>(y - BonnetTop(style_, size_, x));
      if (below >= 0.0f) {
        const float grain = FractalNoise(static_cast<float>(x), static_cast<float>(y),
                                         style_.seed + 3, 1.0f, {24.0f, 4, 0.6f});
        const float rim = std::exp(-below / (0.012f * size_.height));
        const float paint = 0.22f * (1.0f + 0.12f * grain) + 0.35f * rim;
        pixel = {paint, 1.02f * paint, 1.08f * paint};
        continue;
      }
      const float m = reflection_.at<float>(y, x);
      pixel = pixel * (1.0f - 0.25f * m) + cv::Vec3f(0.9f, 0.95f, 1.0f) * (strength * m);
    }
  }
}

void OwnVehicle::Stamp(double seconds, cv::Mat* image) const {
  (*image)(stamp_).setTo(cv::Scalar(20, 20, 20));
  const cv::Point foot(stamp_.x + 2, stamp_.y + stamp_.height * 3 / 4);
  cv::putText(*image, StampText(seconds), foot, kFont, scale_, cv::Scalar(240, 240, 240),
              thickness_, cv::LINE_AA);
}

}  // namespace egosieve::vision
