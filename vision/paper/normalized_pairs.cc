#include "vision/paper/normalized_pairs.h"

#include <Eigen/LU>
#include <cmath>

namespace egosieve::vision {
namespace {

Eigen::Matrix3d Transform(double scale, double cx, double cy) {
  Eigen::Matrix3d t;
  t << 1.0 / scale, 0.0, -cx / scale, 0.0, 1.0 / scale, -cy / scale, 0.0, 0.0, 1.0;
  return t;
}

}  // namespace

NormalizedPairs Normalize(const std::vector<PointPair>& pairs, const std::vector<int64_t>& order) {
  NormalizedPairs result;
  if (order.empty()) return result;
  const double n = static_cast<double>(order.size());
  double cx1 = 0, cy1 = 0, cx2 = 0, cy2 = 0;
  for (const int64_t i : order) {
    cx1 += pairs[i].x1 / n;
    cy1 += pairs[i].y1 / n;
    cx2 += pairs[i].x2 / n;
    cy2 += pairs[i].y2 / n;
  }
  double squares = 0.0;
  for (const int64_t i : order) {
    const PointPair& p = pairs[i];
    squares += (p.x1 - cx1) * (p.x1 - cx1) + (p.y1 - cy1) * (p.y1 - cy1) +
               (p.x2 - cx2) * (p.x2 - cx2) + (p.y2 - cy2) * (p.y2 - cy2);
  }
  const double scale = std::sqrt(squares / (2.0 * n));
  if (scale > 0.0) result.scale_pixels = scale;
  result.t1 = Transform(result.scale_pixels, cx1, cy1);
  result.t2 = Transform(result.scale_pixels, cx2, cy2);
  for (const int64_t i : order) {
    result.x1.push_back(static_cast<float>((pairs[i].x1 - cx1) / result.scale_pixels));
    result.y1.push_back(static_cast<float>((pairs[i].y1 - cy1) / result.scale_pixels));
    result.x2.push_back(static_cast<float>((pairs[i].x2 - cx2) / result.scale_pixels));
    result.y2.push_back(static_cast<float>((pairs[i].y2 - cy2) / result.scale_pixels));
  }
  return result;
}

Eigen::Matrix3d FundamentalInPixels(const Eigen::Matrix3d& f, const NormalizedPairs& pairs) {
  const Eigen::Matrix3d pixels = pairs.t2.transpose() * f * pairs.t1;
  return pixels / pixels.norm();
}

Eigen::Matrix3d HomographyInPixels(const Eigen::Matrix3d& h, const NormalizedPairs& pairs) {
  return pairs.t2.inverse() * h * pairs.t1;
}

}  // namespace egosieve::vision
