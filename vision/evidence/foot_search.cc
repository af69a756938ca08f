#include "vision/evidence/foot_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr int kHalfWidth = 3, kHalfHeight = 1;  // of a strip, pixels
constexpr int kStripPixels = (2 * kHalfWidth + 1) * (2 * kHalfHeight + 1);
constexpr double kIndependentShare = 0.25;  // kappa, as of (S1)
constexpr double kMostOfARow = 5.0, kDoubt = 1.0;

using Strip = std::array<float, kStripPixels>;

// The strip around (x, y), its pixels taken from where `place` has them, less its mean.
template <typename Place>
Strip Take(const cv::Mat& picture, double x, double y, const Place& place) {
  Strip strip;
  float sum = 0.0f;
  for (int v = -kHalfHeight, i = 0; v <= kHalfHeight; ++v) {
    for (int u = -kHalfWidth; u <= kHalfWidth; ++u, ++i) {
      const Eigen::Vector2d at = place(x + u, y + v);
      strip[i] = SampleAt(picture, at(0), at(1));
      sum += strip[i];
    }
  }
  for (float& value : strip) value -= sum / kStripPixels;
  return strip;
}

double Difference(const Strip& a, const Strip& b) {
  double sum = 0.0;
  for (int i = 0; i < kStripPixels; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace

FootSearch::FootSearch(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                       cv::Mat before, cv::Mat now, double noise_levels)
    : road_(road),
      camera_(camera),
      back_(Inverse(pose)),
      before_(std::move(before)),
      now_(std::move(now)),
      noise_levels_(noise_levels) {}

double FootSearch::Gain(double x, double y, double inverse_depth) const {
  const auto moved = [&](const Eigen::Vector3d& ray, double r) {
    return camera_.Project(back_.rotation * ray + r * back_.translation);
  };
  const Strip here = Take(now_, x, y, [](double u, double v) { return Eigen::Vector2d(u, v); });
  const Strip as_road = Take(before_, x, y, [&](double u, double v) {
    const Eigen::Vector3d ray = camera_.Ray(u, v);
    return moved(ray, road_.At(ray));
  });
  const Strip as_object = Take(
      before_, x, y, [&](double u, double v) { return moved(camera_.Ray(u, v), inverse_depth); });
  const double road = Difference(here, as_road), object = Difference(here, as_object);
  const double variance =
      std::max(noise_levels_ * noise_levels_, std::min(road, object) / kStripPixels);
  return kIndependentShare * (road - object) / (2.0 * variance);
}

Eigen::Vector3d FootSearch::LowestFoot(cv::Point2f top, cv::Point2f bottom,
                                       double inverse_depth) const {
  const int rows = std::max(0, static_cast<int>(bottom.y - top.y));
  std::vector<double> sums;
  double sum = 0.0, best = 0.0;
  for (int k = 0; k <= rows; ++k) {
    const double gain = Gain(top.x, top.y + k, inverse_depth);
    if (std::isfinite(gain)) sum += std::clamp(gain, -kMostOfARow, kMostOfARow);
    sums.push_back(sum);
    best = std::max(best, sum);
  }
  int foot = rows;
  if (best >= kDoubt) {
    while (foot > 0 && sums[foot] <= best - kDoubt) --foot;
  }
  return camera_.Ray(top.x, std::min<double>(top.y + foot + 1, bottom.y));
}

}  // namespace egosieve::vision
