#include "vision/evidence/guided_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr double kMostChange = 0.15, kLeastTexture = 2.0, kMostApart = 3.0;

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
template <typename Motion>
Patch Take(const cv::Mat& picture, cv::Point2f place, const Motion& motion) {
  Patch patch;
  for (int y = -kPatchRadius, i = 0; y <= kPatchRadius; ++y) {
    for (int x = -kPatchRadius; x <= kPatchRadius; ++x, ++i) {
      const Eigen::Vector2d at = motion(Eigen::Vector2d(place.x + x, place.y + y));
      patch[i] = Sample(picture, at(0), at(1));
    }
  }
  return patch;
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
    Patch p = Take(now_, place, [](const Eigen::Vector2d& at) { return at; });
    Patch s = Take(before_, place, [&](const Eigen::Vector2d& at) { return Moved(at); });
    const double apart = SubtractMean(p) - SubtractMean(s);
    const double texture = SquaredDifference(p, Patch{}), change = SquaredDifference(p, s);
    const double least =
        kPatchPixels * kLeastTexture * kLeastTexture * noise_levels_ * noise_levels_;
    if (texture >= least) return change <= kMostChange * texture ? Shown::kRoad : Shown::kOther;
    const bool is_alike = std::abs(apart) <= kMostApart * noise_levels_ && change <= least;
    return is_alike ? Shown::kBlank : Shown::kOther;
  }
  cv::Point2f Before(cv::Point2f place) const {
    const Eigen::Vector2d at = Moved({place.x, place.y});
    return {static_cast<float>(at(0)), static_cast<float>(at(1))};
  }

 private:
  Eigen::Vector2d Moved(const Eigen::Vector2d& place) const {
    return (motion_ * place.homogeneous()).hnormalized();
  }

  const RoadPlane& road_;
  const Pinhole& camera_;
  const cv::Mat &before_, &now_;
  double noise_levels_;
  Eigen::Matrix3d motion_;  // of the road, now to before
};

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
    // What was seen last from the picture's lower edge up to `y`, blank places left out.
    bool is_road_below = true;
    float y = static_cast<float>(now.rows - kPatchRadius - 2);
    for (const cv::Point2f place : column) {
      const Shown shown = pictures.At(place);
      for (; shown == Shown::kBlank && y > place.y; y -= kPatchRadius + 1) {
        const Shown below = pictures.At({x, y});
        if (below != Shown::kBlank) is_road_below = below == Shown::kRoad;
      }
      if (shown == Shown::kRoad || (shown == Shown::kBlank && is_road_below)) {
        matches.push_back({place, pictures.Before(place)});
      }
    }
  }
  return matches;
}

}  // namespace egosieve::vision
