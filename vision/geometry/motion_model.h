// The kind of model of the camera's motion between two frames.
#pragma once

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

}  // namespace egosieve::vision
