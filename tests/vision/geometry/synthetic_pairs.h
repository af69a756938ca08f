// Point pairs of made-up scenes with known motion: what a camera of focal length 700 sees at 1242 x
// 375.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision::testing {

enum class CameraMotion { kStatic, kRotation, kPlanar, kForward, kSideways };

struct SyntheticOptions {
  CameraMotion motion = CameraMotion::kForward;
  int count = 1500;
  double mover_share = 0.2;    // in up to four objects, each moving by itself
  double outlier_share = 0.0;  // false matches: anywhere in the second image
  double noise_pixels = 0.5;   // one standard deviation of each coordinate, in both images
  uint64_t seed = 1;
};

struct SyntheticPairs {
  std::vector<PointPair> pairs;
  std::vector<bool> is_mover;   // movers and false matches
  Eigen::Matrix3d fundamental;  // of the static world; zero without translation
  Eigen::Matrix3d homography;   // of the static world where it has one; else zero
};

SyntheticPairs MakeSyntheticPairs(const SyntheticOptions& options);

}  // namespace egosieve::vision::testing
