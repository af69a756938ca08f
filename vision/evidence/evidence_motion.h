// Result of steps 1 and 2 of evidence_accumulator.h. Internal to it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/evidence_accumulator.h"

namespace egosieve::vision {

inline bool IsKnown(cv::Point2f p) { return std::isfinite(p.x) && std::isfinite(p.y); }

struct EvidenceAccumulator::Motion {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Pinhole camera;
  RelativePose pose;
  bool pose_line = false;
  double noise_pixels = 0.0;
};

}  // namespace egosieve::vision
