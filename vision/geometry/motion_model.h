// The model of the camera's motion between two frames.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace egosieve::vision {

// The effect of the camera's motion on the image of a static scene.
enum class MotionModelKind {
  kNone,         // nothing could be estimated
  kStatic,       // x2 = x1: the camera does not move
  kHomography,   // x2 ~ H x1: rotation, a plane, or too little parallax
  kFundamental,  // x2^T F x1 = 0: translation in a scene with depth
};

inline const char* Name(MotionModelKind kind) {
  switch (kind) {
    case MotionModelKind::kNone:
      return "none";
    case MotionModelKind::kStatic:
      return "static";
    case MotionModelKind::kHomography:
      return "homography";
    case MotionModelKind::kFundamental:
      return "fundamental";
  }
  return "unknown";
}

struct MotionModel {
  MotionModelKind kind = MotionModelKind::kNone;
  // F in pixels, first image to second; of vision/paper/fundamental_fit.h alone.
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  int64_t inlier_count = 0;      // pairs near the model
  double parallax_pixels = 0.0;  // of two_view_motion.h; 0 where not measured
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

}  // namespace egosieve::vision
