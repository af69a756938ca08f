// The road as a plane in inverse depth.
//
// Between two views every point has a measured inverse depth r (base: the current frame, units
// of 1/|t|). For points of a plane n.X = h it is linear in the ray A = K^-1 x:
//
//   r = m.A,   m = n |t| / h                                                                 (R1)
//
// The speed of the ground (ground_speed.h) and the direction of travel tell it for level ground, m0.
// The places on the road correct it: m is the most probable one,
//
//   m = argmin sum (r - m.A)^2 / s^2 + |D (m - m0)|^2 / m0_y^2                               (R2)
//
// over the points in the lower middle of the image that are within kNearPlane deviations s of m.A,
// of those that have image motion; points without it are on a bonnet, or on a blank road that flow
// does not follow. D has the inverse deviations of roll, speed and pitch. It is found by reweighted
// least squares that begin at m0. Evidence from the road: road_contact.h.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

inline constexpr double kRoadUnevenness = 0.08;  // of r, deviation of a road from a plane

struct InverseDepth {
  bool valid = false;
  Eigen::Vector3d ray = Eigen::Vector3d::UnitZ();  // A, third component 1
  double value = 0.0;                              // r
  double deviation = 0.0;                          // sigma_r
  bool is_textured = true;                         // false: the flow may be the background's
  bool moves = true;                               // in the image, by more than noise
  // Log-likelihood ratio from grey levels of this depth against the road's (S1), signed.
  double against_road = std::numeric_limits<double>::infinity();
};

// pose: first frame of the pairs to second, found. One per pair, at the place in the second frame.
std::vector<InverseDepth> InverseDepths(const Pinhole& camera, const RelativePose& pose,
                                        const std::vector<PointPair>& pairs);

struct RoadPlane {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();

  double At(const Eigen::Vector3d& ray) const { return m.dot(ray); }
  // A_y below the horizon.
  double Fall(const Eigen::Vector3d& ray) const { return m.dot(ray) / m(1); }
};

// (R2). level: m0, its second component positive.
RoadPlane FitRoad(const std::vector<InverseDepth>& points, const Eigen::Vector3d& level);

}  // namespace egosieve::vision
