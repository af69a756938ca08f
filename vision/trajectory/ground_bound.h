// The ground below the horizon: nothing static is farther than it.
//
// For a camera that is upright and moves forward over level ground, with tau as in
// two_view_motion.h, the horizon passes through the point tau_y / tau_z that the camera moves to,
// and the ground's inverse depth along a ray p, in units of 1 / |t|, is
//
//   r_ground(p) = g (p_y - tau_y / tau_z),   g = |t| / (height of the camera)              (GB1)
//
// It is exact, where the r of two_view_motion.h is |d| / |e| = r / (1 + tau_z r): of the road near
// a camera that moves on, the two differ by half.
//
// What stands on the ground hides it, so for everything static r >= r_ground. g is the mode of
// r / (p_y - tau_y / tau_z) over places with parallax: the ground's all agree, a wall's do not.
// Ground falls and cameras roll, so the bound is only `kGroundShare` of that.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_BOUND_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_BOUND_H_

#include <Eigen/Core>
#include <vector>

namespace egosieve::vision {

// A place below the horizon.
struct BelowHorizon {
  double inverse_depth = 0.0;  // r
  double below = 0.0;          // p_y - tau_y / tau_z, rays
};

// The exact inverse depth of a point with |d| / |e| = `parallax`, and the other way; at most 1e3.
double InverseDepthOf(double parallax, const Eigen::Vector3d& tau);
double ParallaxOf(double inverse_depth, const Eigen::Vector3d& tau);

// kGroundShare g; 0 where too few places agree. No inverse depth may be below 0.
double GroundSlopeOf(const std::vector<BelowHorizon>& places);

// g of a slope that GroundSlopeOf gave: |t| in heights of the camera; and the other way.
double CameraHeights(double ground_slope);
double SlopeOfHeights(double heights);

// Whether the camera moves forward or back: else the horizon is not where it moves to.
bool MovesForwardOrBack(const Eigen::Vector3d& tau);

// p_y - tau_y / tau_z; 0 above the horizon, and where the camera does not move forward or back.
double Below(const Eigen::Vector2d& ray, const Eigen::Vector3d& tau);

// The least inverse depth of what is static; 0 where the slope is.
double LeastInverseDepth(double ground_slope, const Eigen::Vector2d& ray,
                         const Eigen::Vector3d& tau);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_BOUND_H_
