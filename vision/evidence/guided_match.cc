#include "vision/evidence/guided_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr double kMostApart = 3.0;
constexpr double kMostStep = 4.0;  // between neighbouring blank places, in noise levels

enum class Shown { kRoad, kBlank, kOther };

struct Look {
  Shown shown = Shown::kOther;
  float level = 0.0f;  // mean of the patch
};

// Whether a patch has texture in both directions. A single edge looks the same when moved along
// itself.
bool IsCorner(const Patch& patch) {
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (int y = 1; y + 1 < kPatchSide; ++y) {
    for (int x = 1; x + 1 < kPatchSide; ++x) {
      const int i = y * kPatchSide + x;
      const double across = patch[i + 1] - patch[i - 1];
      const double down = patch[i + kPatchSide] - patch[i - kPatchSide];
      xx += across * across;
      yy += down * down;
      xy += across * down;
    }
  }
  const double smaller = 0.5 * (xx + yy - std::hypot(xx - yy, 2.0 * xy));
  return smaller >= kLeastCorner * (xx + yy);
}

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
  Look At(cv::Point2f place) const {
    const auto take = [&](const cv::Mat& picture, const Eigen::Matrix3d& motion) {
      const Eigen::Vector3d centre = motion * Eigen::Vector3d(place.x, place.y, 1.0);
      return TakeProjected<kPatchRadius, kPatchRadius>(picture,
                                                       {centre, motion.col(0), motion.col(1)});
    };
    Patch p = take(now_, Eigen::Matrix3d::Identity());
    Patch s = take(before_, motion_);
    const float level = SubtractMean(p), level_before = SubtractMean(s);
    const double texture = SquaredDifference(p, Patch{}), change = SquaredDifference(p, s);
    const double least =
        kPatchPixels * kLeastTexture * kLeastTexture * noise_levels_ * noise_levels_;
    if (texture >= least) {
      if (!(change <= kMostChange * texture)) return {Shown::kOther, level};
      return {IsCorner(p) ? Shown::kRoad : Shown::kBlank, level};
    }
    const bool is_alike =
        std::abs(level - level_before) <= kMostApart * noise_levels_ && change <= least;
    return {is_alike ? Shown::kBlank : Shown::kOther, level};
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

// Whether the road continues without interruption, from the lower edge of the picture upwards.
class RoadBelow {
 public:
  explicit RoadBelow(double noise_levels) : most_step_(kMostStep * noise_levels) {}

  void Add(const Look& look) {
    if (look.shown != Shown::kBlank) {
      goes_on_ = look.shown == Shown::kRoad;
      has_level_ = false;
      return;
    }
    goes_on_ &= !(has_level_ && std::abs(look.level - level_) > most_step_);
    has_level_ = true;
    level_ = look.level;
  }
  bool GoesOn() const { return goes_on_; }

 private:
  double most_step_;
  bool goes_on_ = true;
  bool has_level_ = false;  // the last place was blank, and `level_` is its level
  float level_ = 0.0f;
};

// Places of one x.
std::vector<GuidedPlace> MatchColumn(const RoadPictures& pictures, std::vector<cv::Point2f> column,
                                     double noise_levels, int rows) {
  std::sort(column.begin(), column.end(), [](auto a, auto b) { return a.y > b.y; });
  std::vector<GuidedPlace> matches;
  RoadBelow road_below(noise_levels);
  float y = static_cast<float>(rows - kPatchRadius - 2);
  for (const cv::Point2f place : column) {
    const Look look = pictures.At(place);
    if (look.shown == Shown::kBlank) {
      for (; y > place.y; y -= kPatchRadius + 1) road_below.Add(pictures.At({place.x, y}));
      road_below.Add(look);
    }
    if (look.shown == Shown::kRoad || (look.shown == Shown::kBlank && road_below.GoesOn())) {
      matches.push_back({place, pictures.Before(place)});
    }
  }
  return matches;
}

}  // namespace

std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places) {
  const RoadPictures pictures(road, camera, pose, before, now, noise_levels);
  std::map<float, std::vector<cv::Point2f>> by_x;
  for (const cv::Point2f place : places) {
    if (pictures.IsBelowHorizon(place)) by_x[place.x].push_back(place);
  }
  std::vector<std::vector<cv::Point2f>> columns;
  for (auto& [x, column] : by_x) columns.push_back(std::move(column));
  std::vector<std::vector<GuidedPlace>> of_columns(columns.size());
  kernels::ParallelFor(static_cast<int64_t>(columns.size()), [&](int64_t k) {
    of_columns[k] = MatchColumn(pictures, std::move(columns[k]), noise_levels, now.rows);
  });
  std::vector<GuidedPlace> matches;
  for (const std::vector<GuidedPlace>& column : of_columns) {
    matches.insert(matches.end(), column.begin(), column.end());
  }
  return matches;
}

}  // namespace egosieve::vision
