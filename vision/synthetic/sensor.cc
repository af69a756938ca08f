#include "vision/synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "vision/image/bilinear.h"
#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

constexpr int kCurveEntries = 16384;
constexpr float kCurveEnd = 5.0f;  // 1 - exp(-5) equals white within a grey level

std::vector<float> ResponseCurve() {  // (SE4)
  std::vector<float> curve(kCurveEntries);
  for (int k = 0; k < kCurveEntries; ++k) {
    const double linear = 1.0 - std::exp(-kCurveEnd * k / kCurveEntries);
    const double srgb =
        linear < 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    const double bent = srgb * srgb * (3.0 - 2.0 * srgb);
    curve[k] = static_cast<float>(255.0 * (0.3 * srgb + 0.7 * bent));
  }
  return curve;
}

// Sum of four bytes, centred and scaled to variance 1: nearly Gaussian up to 3 sigma.
float PseudoGaussian(uint32_t hash) {
  const uint32_t sum = (hash & 255u) + ((hash >> 8) & 255u) + ((hash >> 16) & 255u) + (hash >> 24);
  return (static_cast<float>(sum) - 510.0f) / 147.8f;
}

cv::Vec3f Blurred(const cv::Mat& radiance, const cv::Mat& motion, int x, int y) {  // (SE1)
  const cv::Vec2f path = motion.at<cv::Vec2f>(y, x);
  const float length = std::hypot(path[0], path[1]);
  if (!(length > 0.6f)) return radiance.at<cv::Vec3f>(y, x);
  const int samples = std::min(static_cast<int>(std::ceil(length)) + 1, 9);
  cv::Vec3f sum(0, 0, 0);
  for (int k = 0; k < samples; ++k) {
    const float t = (static_cast<float>(k) + 0.5f) / static_cast<float>(samples) - 0.5f;
    sum += SampleClamped<cv::Vec3f>(radiance, static_cast<float>(x) + t * path[0],
                                    static_cast<float>(y) + t * path[1]);
  }
  return sum * (1.0f / static_cast<float>(samples));
}

// (SE1) of the whole picture, then the lens's spread (SE2).
cv::Mat Optics(const cv::Mat& radiance, const cv::Mat& motion, int threads) {
  cv::Mat moved = radiance;
  if (!motion.empty()) {
    moved = cv::Mat(radiance.size(), CV_32FC3);
    kernels::ParallelFor(radiance.rows, {.threads = threads}, [&](int y) {
      for (int x = 0; x < radiance.cols; ++x)
        moved.at<cv::Vec3f>(y, x) = Blurred(radiance, motion, x, y);
    });
  }
  constexpr float kSide = 0.11f;  // of the energy, in the pixels above, below, left and right
  cv::Mat spread(radiance.size(), CV_32FC3);
  kernels::ParallelFor(radiance.rows, {.threads = threads}, [&](int y) {
    const auto* above = moved.ptr<cv::Vec3f>(std::max(y - 1, 0));
    const auto* here = moved.ptr<cv::Vec3f>(y);
    const auto* below = moved.ptr<cv::Vec3f>(std::min(y + 1, moved.rows - 1));
    auto* out = spread.ptr<cv::Vec3f>(y);
    for (int x = 0; x < moved.cols; ++x) {
      const cv::Vec3f& left = here[std::max(x - 1, 0)];
      const cv::Vec3f& right = here[std::min(x + 1, moved.cols - 1)];
      out[x] = here[x] * (1.0f - 4.0f * kSide) + (above[x] + below[x] + left + right) * kSide;
    }
  });
  return spread;
}

}  // namespace

cv::Mat Expose(const cv::Mat& radiance, const cv::Mat& motion, const SensorSettings& settings,
               double gain, uint32_t seed, int threads) {
  static const auto* const curve = new std::vector<float>(ResponseCurve());
  const cv::Mat light = Optics(radiance, motion, threads);
  cv::Mat image(radiance.size(), CV_8UC3);
  const float read = static_cast<float>(settings.read_noise * settings.read_noise);
  const float shot = static_cast<float>(settings.shot_noise * settings.shot_noise);
  kernels::ParallelFor(radiance.rows, {.threads = threads}, [&](int y) {
    for (int x = 0; x < radiance.cols; ++x) {
      const uint32_t pixel = Hash(seed, x, y);
      auto& out = image.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) {
        float e = static_cast<float>(gain) * light.at<cv::Vec3f>(y, x)[c];
        e += std::sqrt(read + shot * e) *
             PseudoGaussian(Hash(pixel + static_cast<uint32_t>(c)));  // (SE3)
        const float place = std::clamp(e * (kCurveEntries / kCurveEnd), 0.0f, kCurveEntries - 1.0f);
        out[2 - c] = cv::saturate_cast<uchar>((*curve)[static_cast<size_t>(place)]);
      }
    }
  });
  return image;
}

}  // namespace egosieve::vision
