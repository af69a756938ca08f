// The terms of (BA4) of bundle_adjustment.h, for Ceres.
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "vision/trajectory/bundle_adjustment.h"

namespace egosieve::vision {

inline constexpr double kLogFocalScale = 0.4, kScaleDeviation = 0.1;
inline constexpr double kDistortionDeviation = 0.2;
inline constexpr double kCourse = 1.2, kCourseDeviation = 0.8;
inline constexpr int kUndistortSteps = 5;
inline constexpr double kLeastSlope = 0.1;   // of a lens that does not fold
inline constexpr double kLeastDepth = 1e-3;  // of X; nearer points are moved to this depth

// |u| over |x - c| / f, where a is k1 |x - c|^2 / f^2. By Newton's method.
template <typename T>
T UndistortedShare(const T& a, const T& kappa) {
  T t(1.0);
  for (int k = 0; k < kUndistortSteps; ++k) {
    const T z = a * t * t;
    const T slope = 1.0 + z * (3.0 + 5.0 * kappa * z);
    t -= (t * (1.0 + z * (1.0 + kappa * z)) - 1.0) / (slope > kLeastSlope ? slope : T(kLeastSlope));
  }
  return t;
}

// (BA3) / sigma of one observation. log_ratio: log(f / L). distortion: k1, kappa.
// pose: R as angle times axis, then t.
struct Reprojection {
  // Positions in the first picture and in this one, relative to the principal point, pixels.
  cv::Point2d start, seen;
  double side = 0.0;   // L
  double noise = 0.0;  // sigma

  template <typename T>
  bool operator()(const T* log_ratio, const T* distortion, const T* pose, const T* inverse_depth,
                  T* residual) const {
    const T focal = exp(*log_ratio) * side;
    const T u = start.x / focal, v = start.y / focal;
    const T share = UndistortedShare(distortion[0] * (u * u + v * v), distortion[1]);
    const T ray[3] = {share * u, share * v, T(1.0)};
    T point[3];
    ceres::AngleAxisRotatePoint(pose, ray, point);
    for (int k = 0; k < 3; ++k) point[k] += *inverse_depth * pose[3 + k];
    const T depth = point[2] > kLeastDepth ? point[2] : T(kLeastDepth);
    const T x = point[0] / depth, y = point[1] / depth;
    const T z = distortion[0] * (x * x + y * y);
    const T scale = focal * (1.0 + z * (1.0 + distortion[1] * z));
    residual[0] = (scale * x - seen.x) / noise;
    residual[1] = (scale * y - seen.y) / noise;
    return true;
  }
};

struct ScaleGauge {
  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    const T square = pose[3] * pose[3] + pose[4] * pose[4] + pose[5] * pose[5];
    residual[0] = (sqrt(square + 1e-12) - 1.0) / kScaleDeviation;
    return true;
  }
};

struct FocalPrior {
  template <typename T>
  bool operator()(const T* log_ratio, T* residual) const {
    residual[0] = (*log_ratio - std::log(AdjustedLens().focal_ratio)) / kLogFocalScale;
    return true;
  }
};

struct DistortionPrior {
  template <typename T>
  bool operator()(const T* distortion, T* residual) const {
    residual[0] = distortion[0] / kDistortionDeviation;
    residual[1] = (distortion[1] - kCourse) / kCourseDeviation;
    return true;
  }
};

// -log t_3 of a residual, without its constant.
inline ceres::LossFunction* StudentThree() {
  return new ceres::ScaledLoss(new ceres::CauchyLoss(std::sqrt(3.0)), 4.0 / 3.0,
                               ceres::TAKE_OWNERSHIP);
}

}  // namespace egosieve::vision
