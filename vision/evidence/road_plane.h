// The road as a plane in inverse depth.
//
// Between two views every point has a measured inverse depth r (epipolar_line.h; base: the current
// frame, units of 1/|t|). For points of a plane n.X = h it is linear in the ray A = K^-1 x:
//
//   r = m.A,   m = n |t| / h                                                                 (R1)
//
// m is fitted to the points in the lower middle of the image that have image motion; points without
// it are on a bonnet, or on a blank road that flow does not follow. The fit uses seeded samples of
// three points and reweighted least squares. It stays near the last frame's slope m / m_y if that
// is known. The plane counts as a road if it has support and few points lie below it. On blank
// asphalt flow is arbitrary, so a point below the plane counts only if the grey levels agree. A
// single picture shows such a plane among rocks, too, so the plane has to be confirmed (RoadSlope).
// Evidence from the road: road_contact.h.
//
// Reference: Klappstein, Stein & Franke (2006), positive height constraint.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

// m / m_y of the last plane that was found.
struct RoadSlope {
  bool known = false;     // confirmed by another picture or by the direction of travel
  bool proposed = false;  // found in at least one picture
  double across = 0.0;    // m_x / m_y: roll
  double horizon = 0.0;   // -m_z / m_y: A_y of the horizon in the middle of the image
  int unseen = 0;         // frames since it was found
};

// Whether the two differ by no more than a jolt changes the slope from picture to picture.
bool AreAlike(const RoadSlope& a, const RoadSlope& b);

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
  bool found = false;
  Eigen::Vector3d m = Eigen::Vector3d::Zero();

  RoadSlope slope() const { return {false, true, m(0) / m(1), -m(2) / m(1)}; }
  double support = 0.0;  // share of the points of the lower middle that are on it

  double At(const Eigen::Vector3d& ray) const { return m.dot(ray); }
  // A_y below the horizon.
  double Fall(const Eigen::Vector3d& ray) const { return m.dot(ray) / m(1); }
};

// Whether grey levels confirm that the point of this index is not on the plane.
using IsSeenOffPlane = std::function<bool(const RoadPlane& plane, size_t point)>;

// is_seen_off: null without pictures.
RoadPlane FitRoad(const std::vector<InverseDepth>& points, const RoadSlope& last, uint64_t seed,
                  const IsSeenOffPlane& is_seen_off = nullptr);

}  // namespace egosieve::vision
