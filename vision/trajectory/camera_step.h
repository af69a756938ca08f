// The camera's motion from one picture to the next, as measured in one frame, and the trajectory
// that results from these steps.
//
// Frame k belongs to two pairs: one ends in it, over g pictures, and one begins in it, over n. A
// static point has the inverse depths r_b and r_a, in units of the lengths of the two translations,
// so
//
//   lambda = |t_b| / |t_a| = sum w r_b r_a / sum w r_a^2,  w the precision of r_b           (CS1)
//
// The camera's speed behind and ahead is lambda |t_a| / g and |t_a| / n. The two values are (g + n)
// / 2 pictures apart, so the next step is longer than this one by the factor
//
//   onward = (g / (lambda n))^(2 / (g + n))                                                 (CS2)
//
// Where the ground is known (ground_bound.h), its slope is the step's length in heights of the
// camera, a unit that is the same over the drive. Elsewhere only ratios of lengths are known, and
// their product drifts. The logarithms of the lengths are smoothed over the drive, forwards and
// backwards (Rauch, Tung & Striebel, 1965). They change by log(onward), or follow a random walk
// where that is not known, and the ground observes them                                    (CS3)
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

inline constexpr double kOnwardError = 0.05;  // deviation of the logarithm of (CS2)
inline constexpr double kGroundError = 0.15;  // of the logarithm of a length by the ground

// X_k = R X_(k-1) + t, from the previous picture to this one.
struct CameraStep {
  bool known = false;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();   // of R, as a vector, radians
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // t / |t|; 0: the camera does not travel
  double onward = 0.0;                                  // (CS2); 0: not known
  double heights = 0.0;  // |t| in heights of the camera; 0: not known
};

// A point in the labelled frame k and in the two pictures, pixels.
struct PlaceOnBothSides {
  PointPair behind;  // from the earlier picture to frame k
  PointPair ahead;   // from frame k to the later one
};

// The pairs that end and begin in frame k.
struct StepViews {
  const TwoViewMotion* behind = nullptr;  // earlier picture to frame k; may be null
  const TwoViewMotion* ahead = nullptr;   // frame k to later picture; may be null
  int pictures_behind = 1, pictures_ahead = 1;
  std::vector<PlaceOnBothSides> places;
};

// rotation: R. The rest of the step follows from the views. The result's `known` is true.
CameraStep MeasureStep(const Eigen::Matrix3d& rotation, const StepViews& views,
                       const Pinhole& camera);

// Poses, camera to world, one per step; the first is the identity, and the first step is not read.
// A step that is not known is replaced by the last known one. Lengths are in heights of the camera
// where the ground is known in some step, else in lengths of the first step with translation.
std::vector<Eigen::Isometry3d> ChainSteps(const std::vector<CameraStep>& steps);

}  // namespace egosieve::vision
