#include "vision/evidence/guided_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>

namespace egosieve::vision {
namespace {

constexpr int kRadius = 3;
constexpr int kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr double kMostChange = 0.15, kLeastTexture = 2.0, kMostApart = 3.0;

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

// The patch around a place, its pixels taken from where `motion` has them. NaN where it leaves the
// picture.
Patch Take(const cv::Mat& picture, const Eigen::Matrix3d& motion, cv::Point2f place) {
  Patch patch;
  for (int y = -kRadius, i = 0; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x, ++i) {
      const Eigen::Vector2d at =
          (motion * Eigen::Vector3d(place.x + x, place.y + y, 1.0)).hnormalized();
      patch[i] = Sample(picture, at(0), at(1));
    }
  }
  return patch;
}

// Returns the mean.
float SubtractMean(Patch& patch) {
  const float mean = std::accumulate(patch.begin(), patch.end(), 0.0f) / kPixels;
  for (float& value : patch) value -= mean;
  return mean;
}

double SquaredDifference(const Patch& a, const Patch& b) {
  float sum = 0.0f;
  for (int i = 0; i < kPixels; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

enum class Shown { kRoad, kBlank, kOther };

class RoadPictures {
 public:
  RoadPictures(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
               const cv::Mat& before, const cv::Mat& now, double noise_levels)
      : road_(road), camera_(camera), before_(before), now_(now), noise_levels_(noise_levels) {
    const RelativePose back = Inverse(pose);
    const Eigen::Matrix3d k = camera.Matrix();
    motion_ = k * (back.rotation + back.translation * road.m.transpose()) * k.inverse();
  }

  bool IsBelowHorizon(cv::Point2f place) const {
    return road_.At(camera_.Ray(place.x, place.y)) > 0.0;
  }
  Shown At(cv::Point2f place) const {
    Patch p = Take(now_, Eigen::Matrix3d::Identity(), place), s = Take(before_, motion_, place);
    const double apart = SubtractMean(p) - SubtractMean(s);
    const double texture = SquaredDifference(p, Patch{}), change = SquaredDifference(p, s);
    const double least = kPixels * kLeastTexture * kLeastTexture * noise_levels_ * noise_levels_;
    if (texture >= least) return change <= kMostChange * texture ? Shown::kRoad : Shown::kOther;
    const bool is_alike = std::abs(apart) <= kMostApart * noise_levels_ && change <= least;
    return is_alike ? Shown::kBlank : Shown::kOther;
  }
  cv::Point2f Before(cv::Point2f place) const {
    const Eigen::Vector2d at = (motion_ * Eigen::Vector3d(place.x, place.y, 1.0)).hnormalized();
    return {static_cast<float>(at(0)), static_cast<float>(at(1))};
  }

 private:
  const RoadPlane& road_;
  const Pinhole& camera_;
  const cv::Mat &before_, &now_;
  double noise_levels_;
  Eigen::Matrix3d motion_;  // of the road, now to before
};

// Whether nothing but road is seen below each place of a column; places: upwards.
std::vector<bool> StandOnRoad(const RoadPictures& pictures, const std::vector<cv::Point2f>& places,
                              int height) {
  std::vector<bool> result;
  bool is_road = true;
  float y = static_cast<float>(height - kRadius - 2);
  for (const cv::Point2f place : places) {
    for (; y > place.y; y -= kRadius + 1) {
      const Shown shown = pictures.At({place.x, y});
      if (shown != Shown::kBlank) is_road = shown == Shown::kRoad;
    }
    result.push_back(is_road);
  }
  return result;
}

}  // namespace

std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places) {
  const RoadPictures pictures(road, camera, pose, before, now, noise_levels);
  std::map<float, std::vector<cv::Point2f>> columns;
  for (const cv::Point2f place : places) {
    if (pictures.IsBelowHorizon(place)) columns[place.x].push_back(place);
  }
  std::vector<GuidedPlace> matches;
  for (auto& [x, column] : columns) {
    std::sort(column.begin(), column.end(), [](auto a, auto b) { return a.y > b.y; });
    const std::vector<bool> stands_on_road = StandOnRoad(pictures, column, now.rows);
    for (size_t i = 0; i < column.size(); ++i) {
      const Shown shown = pictures.At(column[i]);
      if (shown == Shown::kRoad || (shown == Shown::kBlank && stands_on_road[i])) {
        matches.push_back({column[i], pictures.Before(column[i])});
      }
    }
  }
  return matches;
}

}  // namespace egosieve::vision
