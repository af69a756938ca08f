// Points that stand neither on the road nor on anything that stands on it.
//
// Between two views every point has a measured inverse depth r (epipolar_line.h; base: the current
// frame, units of 1/|t|). For points of a plane n.X = h it is linear in the ray A = K^-1 x:
//
//   r = m.A,   m = n |t| / h                                                                 (R1)
//
// m is found among the points of the lower middle of the image, by seeded sampling of three and
// reweighted least squares, near the last frame's slope m / m_y. It counts as a road where it has
// support and hardly anything lies below it. A static point is not below the road,
//
//   r >= m.A                                                                                 (R2)
//
// and what stands on the road has the road's depth at its foot. A stretch of alike points in a
// column of the image, below which road is seen, has its foot there:
//
//   r_stretch = m.A_foot                                                                     (R3)
//
// and the stretch rises no more than kMostRise camera heights above the camera: houses and trees
// do. A car ahead seems too far for its foot, infinitely far at equal speed; an oncoming one too
// near: with v_o its speed and v the camera's, (v_o + v) / v times as near. Both hold whatever the
// direction of the epipolar lines. (R2) and (R3) have slack, for roads are not plane and bumpers
// hang above them.
//
// Nothing is said without a pose or a plane. Reference: Klappstein, Stein & Franke (2006), positive
// height constraint.
#ifndef EGOSIEVE_VISION_EVIDENCE_ROAD_PLANE_H_
#define EGOSIEVE_VISION_EVIDENCE_ROAD_PLANE_H_

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// m over m_y of the last frame.
struct RoadSlope {
  bool known = false;
  double across = 0.0;   // m_x / m_y: roll
  double horizon = 0.0;  // -m_z / m_y: A_y of the horizon in the middle of the image
};

struct InverseDepth {
  bool valid = false;
  Eigen::Vector3d ray = Eigen::Vector3d::UnitZ();  // A, third component 1
  double value = 0.0;                              // r
  double deviation = 0.0;                          // sigma_r
  bool is_textured = true;                         // false: may belong to what is behind
};

// pose: first frame of the pairs to second, found. One a pair, of the second frame's place.
std::vector<InverseDepth> InverseDepths(const Pinhole& camera, const RelativePose& pose,
                                        const std::vector<PointPair>& pairs);

struct RoadPlane {
  bool found = false;
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  double support = 0.0;  // share of the points of the lower middle that are on it

  double At(const Eigen::Vector3d& ray) const { return m.dot(ray); }
  // A_y below the horizon.
  double Fall(const Eigen::Vector3d& ray) const { return m.dot(ray) / m(1); }
};

RoadPlane FitRoad(const std::vector<InverseDepth>& points, const RoadSlope& last, uint64_t seed);

// Log-likelihood ratio by (R2) and (R3), not negative; places: of the points, in the image.
std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_ROAD_PLANE_H_
