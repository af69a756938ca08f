#include "vision/evidence/foot_search.h"

#include <algorithm>
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

// Less its mean.
template <typename Motion>
auto StripAt(const cv::Mat& picture, double x, double y, const Motion& motion) {
  auto strip = TakeMoved<kHalfWidth, kHalfHeight>(picture, x, y, motion);
  SubtractMean(strip);
  return strip;
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
  using Eigen::Vector2d;
  const auto here = StripAt(now_, x, y, [](const Vector2d& at) { return at; });
  const auto as_road = StripAt(before_, x, y, [&](const Vector2d& at) {
    const Eigen::Vector3d ray = camera_.Ray(at(0), at(1));
    return moved(ray, road_.At(ray));
  });
  const auto as_object = StripAt(before_, x, y, [&](const Vector2d& at) {
    return moved(camera_.Ray(at(0), at(1)), inverse_depth);
  });
  const double road = SquaredDifference(here, as_road);
  const double object = SquaredDifference(here, as_object);
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
