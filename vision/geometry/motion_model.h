// The model of the camera's motion between two frames.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/motion_model_kind.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct MotionModel {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // H or F in pixels, first image to second
  int64_t inlier_count = 0;                              // pairs near the model
  int64_t pair_count = 0;
  // The competing model of the other kind, two-dimensional or fundamental; of two-dimensional ones
  // the homography if there is one. kNone without such a model.
  MotionModelKind rejected_kind = MotionModelKind::kNone;
  Eigen::Matrix3d rejected_matrix = Eigen::Matrix3d::Identity();
  // Median transfer error of the best homography, which measures parallax: the motion that the
  // homography does not explain. 0 where no homography was tried.
  double parallax_pixels = 0.0;
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

// Selects and fits a model to pairs of points, without a focal length. Kind kNone with a reason for
// too few or degenerate pairs.
using MotionSelector =
    std::function<absl::StatusOr<MotionModel>(const std::vector<PointPair>& pairs, uint64_t seed)>;

}  // namespace egosieve::vision
