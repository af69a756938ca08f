#include "vision/trajectory/ground_bound.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kGroundShare = 0.85;
constexpr double kForward = 0.7;     // least component of the motion along the optical axis
constexpr double kPeak = 0.15;       // of log(r / below), half width of the mode
constexpr double kLeastShare = 0.2;  // least share of points that agree with the mode
constexpr size_t kFewestPlaces = 40;
constexpr double kGreatest = 1e3;  // of inverse depth and parallax: the camera's own place

}  // namespace

double InverseDepthOf(double parallax, const Eigen::Vector3d& tau) {
  return parallax / std::max(1.0 - tau(2) * parallax, parallax / kGreatest);
}

double ParallaxOf(double inverse_depth, const Eigen::Vector3d& tau) {
  return inverse_depth / std::max(1.0 + tau(2) * inverse_depth, inverse_depth / kGreatest);
}

double GroundSlopeOf(const std::vector<double>& slopes) {
  std::vector<double> logs;
  for (const double slope : slopes) {
    if (slope > 0.0) logs.push_back(std::log(slope));
  }
  if (logs.size() < kFewestPlaces) return 0.0;
  std::sort(logs.begin(), logs.end());
  const auto [first, count] = DensestWindow(logs, 2.0 * kPeak);
  if (static_cast<double>(count) < kLeastShare * static_cast<double>(logs.size())) return 0.0;
  return std::exp(logs[first + count / 2]);
}

double SlopeOfBound(double heights) { return kGroundShare * heights; }

bool MovesForwardOrBack(const Eigen::Vector3d& tau) { return std::abs(tau(2)) >= kForward; }

double Below(const Eigen::Vector2d& ray, const Eigen::Vector3d& tau) {
  if (!MovesForwardOrBack(tau)) return 0.0;
  return std::max(0.0, ray(1) - tau(1) / tau(2));
}

double LeastInverseDepth(double ground_slope, const Eigen::Vector2d& ray,
                         const Eigen::Vector3d& tau) {
  return ground_slope > 0.0 ? ground_slope * Below(ray, tau) : 0.0;
}

}  // namespace egosieve::vision
