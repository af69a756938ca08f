#include "vision/evidence/ground_contact.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr int kHalfWidth = 3, kHalfHeight = 1;  // of a strip, pixels
constexpr int kStripPixels = (2 * kHalfWidth + 1) * (2 * kHalfHeight + 1);
constexpr double kIndependentShare = 0.25;  // kappa, as of (S1)
constexpr double kMostOfARow = 5.0;
constexpr double kHang = 0.15;                          // h
constexpr double kFarBelow = 2.5, kLeastGround = 0.01;  // of LowestGround

// Less its mean.
template <typename Motion>
auto StripAt(const cv::Mat& picture, double x, double y, const Motion& motion) {
  auto strip = TakeMoved<kHalfWidth, kHalfHeight>(picture, x, y, motion);
  SubtractMean(strip);
  return strip;
}

}  // namespace

ContactRatios RatiosOfContact(const std::vector<ContactRow>& rows, const ContactDepths& depths) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  ContactRatios ratios;
  double sum = 0.0, best = kNone, best_not_far = kNone, best_not_near = kNone;
  for (const ContactRow& row : rows) {
    if (std::isfinite(row.gain)) sum += std::clamp(row.gain, -kMostOfARow, kMostOfARow);
    const double r = depths.inverse_depth;
    const double deviation = std::hypot(depths.deviation, depths.unevenness * row.ground);
    const auto [lower, higher] = std::minmax({row.ground, depths.ground_share * row.ground});
    const double far = std::max(0.0, lower - r) / deviation;
    const double near = std::max(0.0, r / (1.0 + kHang) - higher) / deviation;
    if (sum > best) {
      best = sum;
      ratios.ground = row.ground;
    }
    best_not_far = std::max(best_not_far, sum - 0.5 * far * far);
    best_not_near = std::max(best_not_near, sum - 0.5 * near * near);
  }
  if (rows.empty()) return ratios;
  ratios.too_far = best - best_not_far;
  ratios.too_near = best - best_not_near;
  return ratios;
}

double LowestGround(double ground, double inverse_depth) {
  return kFarBelow * std::max({ground, inverse_depth, kLeastGround});
}

ContactPictures::ContactPictures(const RoadPlane& road, const Pinhole& camera,
                                 const RelativePose& pose, cv::Mat before, cv::Mat now,
                                 double noise_levels)
    : road_(road),
      camera_(camera),
      back_(Inverse(pose)),
      before_(std::move(before)),
      now_(std::move(now)),
      noise_levels_(noise_levels) {}

double ContactPictures::Gain(double x, double y, const ContactDepths& depths) const {
  const auto moved = [&](const Eigen::Vector3d& ray, double r) {
    return camera_.Project(back_.rotation * ray + r * back_.translation);
  };
  using Eigen::Vector2d;
  const auto here = StripAt(now_, x, y, [](const Vector2d& at) { return at; });
  const auto difference = [&](const auto& inverse_depth_at) {
    return SquaredDifference(here, StripAt(before_, x, y, [&](const Vector2d& at) {
                               const Eigen::Vector3d ray = camera_.Ray(at(0), at(1));
                               return moved(ray, inverse_depth_at(ray));
                             }));
  };
  using Eigen::Vector3d;
  const double object = difference([&](const Vector3d&) { return depths.inverse_depth; });
  double ground = difference([&](const Vector3d& ray) { return road_.At(ray); });
  if (depths.ground_share != 1.0) {
    ground = std::min(ground, difference([&](const Vector3d& ray) {
                        return depths.ground_share * road_.At(ray);
                      }));
  }
  const double variance =
      std::max(noise_levels_ * noise_levels_, std::min(ground, object) / kStripPixels);
  return kIndependentShare * (ground - object) / (2.0 * variance);
}

std::vector<ContactRow> ContactPictures::RowsBelow(cv::Point2f top,
                                                   const ContactDepths& depths) const {
  std::vector<ContactRow> rows;
  for (double y = top.y; y < now_.rows - kHalfHeight - 1; ++y) {
    ContactRow row;
    row.ground = road_.At(camera_.Ray(top.x, y));
    if (row.ground > depths.lowest) break;
    if (row.ground > 0.0) row.gain = Gain(top.x, y, depths);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace egosieve::vision
