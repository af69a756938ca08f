// The ground as a bound of depth: below the horizon no static point is farther away than the
// ground.
//
// For a camera that is upright and moves forward over level ground, with tau as in
// two_view_motion.h, the horizon passes through the point tau_y / tau_z that the camera moves
// towards. The inverse depth of the ground along a ray p, in units of 1 / |t|, is
//
//   r_ground(p) = g (p_y - tau_y / tau_z),   g = |t| / (height of the camera)              (GB1)
//
// This is exact. The r of two_view_motion.h is |d| / |e| = r / (1 + tau_z r), and for road near a
// camera that moves forward the two differ by half.
//
// Objects on the ground occlude it, so r >= r_ground for every static point. In one pair g is the
// mode of r / (p_y - tau_y / tau_z) over points with parallax: the points of the ground agree,
// those of a wall do not. The bound has `kGroundShare` of the g of the drive (ground_speed.h), since
// ground slopes down and cameras roll.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace egosieve::vision {

// The exact inverse depth of a point with |d| / |e| = `parallax`, and the inverse function; at most
// 1e3.
double InverseDepthOf(double parallax, const Eigen::Vector3d& tau);
double ParallaxOf(double inverse_depth, const Eigen::Vector3d& tau);

// g, from r / (p_y - tau_y / tau_z) of points below the horizon; 0 where too few agree.
double GroundSlopeOf(const std::vector<double>& slopes);

// kGroundShare g, for |t| in heights of the camera.
double SlopeOfBound(double heights);

// Whether the camera moves forward or back. If not, the horizon does not pass through the point
// that it moves towards.
bool MovesForwardOrBack(const Eigen::Vector3d& tau);

// p_y - tau_y / tau_z; 0 above the horizon, and where the camera does not move forward or back.
double Below(const Eigen::Vector2d& ray, const Eigen::Vector3d& tau);

// The least inverse depth of a static point; 0 where the slope is 0.
double LeastInverseDepth(double ground_slope, const Eigen::Vector2d& ray,
                         const Eigen::Vector3d& tau);

}  // namespace egosieve::vision
