#include "vision/evidence/ground_contact.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr int kHalfWidth = 3, kHalfHeight = 1;  // of a strip, pixels
constexpr int kStripPixels = (2 * kHalfWidth + 1) * (2 * kHalfHeight + 1);
constexpr double kContactShare = 0.25;  // kappa, as in (S1)
constexpr double kMostPerRow = 5.0;
constexpr double kHang = 0.15;                          // h
constexpr double kFarBelow = 2.5, kLeastGround = 0.01;  // of LowestGround

using Strip = std::array<float, kStripPixels>;

// The strip less its mean.
Strip StripAt(const cv::Mat& picture, const ProjectedPlaces& places) {
  Strip strip = TakeProjected<kHalfWidth, kHalfHeight>(picture, places);
  SubtractMean(strip);
  return strip;
}

}  // namespace

ContactRatios RatiosOfContact(const std::vector<ContactRow>& rows, const ContactDepths& depths) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  ContactRatios ratios;
  double sum = 0.0, best = kNone, best_not_far = kNone, best_not_near = kNone;
  for (const ContactRow& row : rows) {
    if (std::isfinite(row.gain)) sum += std::clamp(row.gain, -kMostPerRow, kMostPerRow);
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
  using Eigen::Vector3d;
  const Strip here = StripAt(now_, {{x, y, 1.0}, Vector3d::UnitX(), Vector3d::UnitY()});
  // Homogeneous pixel in the frame before, of a ray with its inverse depth; linear in both.
  const auto before = [&](const Vector3d& ray, double inverse_depth) -> Vector3d {
    const Vector3d point = back_.rotation * ray + inverse_depth * back_.translation;
    return {camera_.focal_pixels * point(0) + camera_.centre_x * point(2),
            camera_.focal_pixels * point(1) + camera_.centre_y * point(2), point(2)};
  };
  const Vector3d ray = camera_.Ray(x, y), across = Vector3d::UnitX() / camera_.focal_pixels,
                 down = Vector3d::UnitY() / camera_.focal_pixels;
  const auto difference = [&](const ProjectedPlaces& places) {
    return SquaredDifference(here, StripAt(before_, places));
  };
  const auto on_ground = [&](double share) {
    return difference({before(ray, share * road_.At(ray)), before(across, share * road_.At(across)),
                       before(down, share * road_.At(down))});
  };
  const double object =
      difference({before(ray, depths.inverse_depth), before(across, 0.0), before(down, 0.0)});
  double ground = on_ground(1.0);
  if (depths.ground_share != 1.0) ground = std::min(ground, on_ground(depths.ground_share));
  const double variance =
      std::max(noise_levels_ * noise_levels_, std::min(ground, object) / kStripPixels);
  return kContactShare * (ground - object) / (2.0 * variance);
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
