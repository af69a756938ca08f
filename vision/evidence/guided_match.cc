#include "vision/evidence/guided_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cstdint>
#include <limits>

namespace egosieve::vision {
namespace {

constexpr int kRadius = 3;
constexpr int kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr double kMostChange = 0.15, kLeastTexture = 2.0;

using Patch = std::array<float, kPixels>;

// NaN outside of the picture.
float Sample(const cv::Mat& picture, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < picture.cols - 1 && y < picture.rows - 1)) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
  const uint8_t* upper = picture.ptr<uint8_t>(row) + column;
  const uint8_t* lower = picture.ptr<uint8_t>(row + 1) + column;
  const float above = upper[0] + fx * (upper[1] - upper[0]);
  const float below = lower[0] + fx * (lower[1] - lower[0]);
  return above + fy * (below - above);
}

// The patch around a place, its pixels taken from where `motion` has them, less its mean. NaN where
// it leaves the picture.
Patch Take(const cv::Mat& picture, const Eigen::Matrix3d& motion, cv::Point2f place) {
  Patch patch;
  float sum = 0.0f;
  for (int y = -kRadius, i = 0; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x, ++i) {
      const Eigen::Vector2d at =
          (motion * Eigen::Vector3d(place.x + x, place.y + y, 1.0)).hnormalized();
      patch[i] = Sample(picture, at(0), at(1));
      sum += patch[i];
    }
  }
  for (float& value : patch) value -= sum / kPixels;
  return patch;
}

double SquaredDifference(const Patch& a, const Patch& b) {
  float sum = 0.0f;
  for (int i = 0; i < kPixels; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace

std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places) {
  const RelativePose back = Inverse(pose);
  const Eigen::Matrix3d k = camera.Matrix();
  const Eigen::Matrix3d motion =
      k * (back.rotation + back.translation * road.m.transpose()) * k.inverse();
  const double least = kLeastTexture * noise_levels;
  std::vector<GuidedPlace> matches;
  for (const cv::Point2f place : places) {
    if (!(road.At(camera.Ray(place.x, place.y)) > 0.0)) continue;
    const Patch p = Take(now, Eigen::Matrix3d::Identity(), place);
    const double texture = SquaredDifference(p, Patch{});
    if (!(texture >= kPixels * least * least)) continue;
    if (!(SquaredDifference(p, Take(before, motion, place)) <= kMostChange * texture)) continue;
    const Eigen::Vector2d at = (motion * Eigen::Vector3d(place.x, place.y, 1.0)).hnormalized();
    matches.push_back({place, {static_cast<float>(at(0)), static_cast<float>(at(1))}});
  }
  return matches;
}

}  // namespace egosieve::vision
