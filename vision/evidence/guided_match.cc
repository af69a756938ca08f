#include "vision/evidence/guided_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {
namespace {

constexpr int kRadius = GuidedMatcher::kRadius, kPixels = GuidedMatcher::kPixels;
constexpr double kMostChange = 0.15, kLeastTexture = 2.0;
constexpr double kNearest = 0.6;  // r: 1.7 times the camera's way
constexpr int kMostSteps = 128;  // what is further along the line is not looked for
constexpr int kApart = 3;
constexpr double kNearlyAsWell = 1.5;

using Patch = GuidedMatcher::Patch;

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

// The patch whose pixels lie at at(x, y), x and y from -kRadius to kRadius, less its mean.
template <typename Place>
Patch Take(const cv::Mat& picture, const Place& at) {
  Patch patch;
  float sum = 0.0f;
  for (int y = -kRadius, i = 0; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x, ++i) {
      const Eigen::Vector2d place = at(x, y);
      patch[i] = Sample(picture, place(0), place(1));
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

struct Minimum {
  double place = 0.0, error = 0.0;
};

// Of the parabola through errors[i] and its neighbours where i is the least of the three; else, and
// at an end, of the error alone.
Minimum MinimumAt(const double* errors, int last, int i) {
  const Minimum alone{static_cast<double>(i), errors[i]};
  if (i == 0 || i == last) return alone;
  const double slope = 0.5 * (errors[i + 1] - errors[i - 1]);
  const double bend = errors[i + 1] - 2.0 * errors[i] + errors[i - 1];
  if (!(bend > 0.0 && std::abs(slope) <= 0.5 * bend) || std::isinf(bend)) return alone;
  return {i - slope / bend, std::max(0.0, errors[i] - 0.5 * slope * slope / bend)};
}

cv::Point2f PointOf(const Eigen::Vector2d& place) {
  return {static_cast<float>(place(0)), static_cast<float>(place(1))};
}

}  // namespace

GuidedMatcher::GuidedMatcher(cv::Mat before, cv::Mat now, const Pinhole& camera,
                             const RelativePose& pose, const RoadPlane& road, double noise_levels)
    : before_(std::move(before)),
      now_(std::move(now)),
      camera_(camera),
      back_(Inverse(pose)),
      road_(road),
      noise_levels_(noise_levels) {
  const Eigen::Matrix3d k = camera.Matrix();
  road_motion_ = k * (back_.rotation + back_.translation * road.m.transpose()) * k.inverse();
}

std::vector<GuidedPlace> GuidedMatcher::Match(const std::vector<cv::Point2f>& places) const {
  std::vector<std::optional<GuidedPlace>> found(places.size());
  constexpr double kFlops = 50.0 * 49.0 * 12.0;
  kernels::ParallelFor(static_cast<int64_t>(places.size()),
                       kFlops * static_cast<double>(places.size()),
                       [&](int64_t i) { found[i] = MatchOne(places[i]); });
  std::vector<GuidedPlace> matches;
  for (const std::optional<GuidedPlace>& place : found) {
    if (place) matches.push_back(*place);
  }
  return matches;
}

std::optional<GuidedPlace> GuidedMatcher::MatchOne(cv::Point2f place) const {
  const Patch p =
      Take(now_, [&](int x, int y) { return Eigen::Vector2d(place.x + x, place.y + y); });
  const double texture = SquaredDifference(p, Patch{});
  const double least = kLeastTexture * noise_levels_;
  if (!(texture >= kPixels * least * least)) return std::nullopt;  // (M1)
  if (road_.At(camera_.Ray(place.x, place.y)) > 0.0) {
    const auto on_road = [&](int x, int y) -> Eigen::Vector2d {
      return (road_motion_ * Eigen::Vector3d(place.x + x, place.y + y, 1.0)).hnormalized();
    };
    if (SquaredDifference(p, Take(before_, on_road)) <= kMostChange * texture) {  // (M2)
      return GuidedPlace{place, PointOf(on_road(0, 0)), true, true};
    }
  }
  return SearchLine(place, p, kMostChange * texture);
}

std::optional<GuidedPlace> GuidedMatcher::SearchLine(cv::Point2f place, const Patch& p,
                                                     double most_error) const {
  const EpipolarLine line = LineOf(camera_, back_.rotation, back_.translation, place.x, place.y);
  if (!line.valid) return std::nullopt;
  const double depth = line.ray(2) + kNearest * line.forward;
  if (!(depth > 0.1)) return std::nullopt;
  const double furthest = kNearest * line.gain / depth;
  const int steps = std::clamp(static_cast<int>(std::ceil(furthest)), 2, kMostSteps);
  const double step = std::min(1.0, furthest / steps);
  const auto at = [&](double s) -> Eigen::Vector2d { return line.infinity + s * line.direction; };
  std::array<double, kMostSteps + 1> errors;
  for (int i = 0; i <= steps; ++i) {
    // What is nearer to the one camera is as much larger in its picture.
    const double scale = 1.0 / (line.ray(2) + line.InverseDepth(i * step) * line.forward);
    const Eigen::Vector2d centre = at(i * step);
    errors[i] = SquaredDifference(p, Take(before_, [&](int x, int y) -> Eigen::Vector2d {
                                    return centre + scale * Eigen::Vector2d(x, y);
                                  }));
    if (std::isnan(errors[i])) errors[i] = std::numeric_limits<double>::infinity();
  }
  const auto* first = errors.data();
  const int best = static_cast<int>(std::min_element(first, first + steps + 1) - first);
  if (!(errors[best] <= most_error)) return std::nullopt;  // (M2)
  const Minimum least = MinimumAt(errors.data(), steps, best);
  bool has_depth = true;
  for (int i = 0; i <= steps && has_depth; ++i) {
    has_depth = std::abs(i - best) * step < kApart ||
                MinimumAt(errors.data(), steps, i).error >
                    kNearlyAsWell * (least.error + kPixels * noise_levels_ * noise_levels_);
  }
  return GuidedPlace{place, PointOf(at(least.place * step)), false, has_depth};
}

}  // namespace egosieve::vision
