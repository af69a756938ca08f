// The model of the camera's motion between two frames.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "vision/geometry/motion_model_kind.h"

namespace egosieve::vision {

struct MotionModel {
  MotionModelKind kind = MotionModelKind::kNone;
  // F in pixels, first image to second; of vision/paper/fundamental_fit.h alone.
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  int64_t inlier_count = 0;  // pairs near the model
  int64_t pair_count = 0;
  double parallax_pixels = 0.0;  // of two_view_motion.h; 0 where not measured
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

}  // namespace egosieve::vision
