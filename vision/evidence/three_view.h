// Whether a point's position in a third frame agrees with the depth from the first two. Frames a,
// b, c in order; b is the base.
//
//   1. a and b give the inverse depth of x_b:  r = r(s_ba), units of 1/|t_ab|      epipolar_line.h
//   2. the motion b to c with the scale of a to b:  X_c = A + r tau,  A = R K^-1 x_b          (V1)
//   3. residual  e = x_c - project(X_c)
//   4. its covariance from pixel noise,  u = dx_c/dr,  k = dr/ds,  d = line of x_b in a:
//        C = sigma^2 ( I  +  k^2 u u^T  +  (I - k u d^T)(I - k u d^T)^T )                     (V2)
//      of x_c, x_a and x_b in turn (the rotation's effect on the noise is neglected), and
//        C + J P J^T with the covariance P of (R, tau)                                        (V3)
//   5. the residual along the line,  z = u.e / |u|,  its variance  u^T C u / |u|^2
//
// R and tau start from the pose of b to c and the median ratio of depths, which chains the scale.
// They are fitted to the static majority: minimise sum rho(e^T C^-1 e / m^2) by Gauss-Newton, rho
// of Cauchy, m the robust scale of the residuals (6 parameters). Transfer by two epipolar lines is
// not used, because it fails where the two lines coincide, which is everywhere when driving
// straight.
//
// Detected: movers that change their speed, turn, or whose path is not that of a static point at
// another depth. Not detected: motion at constant velocity parallel to the camera's.
//
// No residual is given if one of the poses was not found, the scale has no support, or the point
// lies near the point of expansion; nor if |tau| is not near 1. Two steps differ by more than
// braking explains only if a picture is missing, and points that were followed over a long step
// have errors along their lines that exceed sigma, which is measured across the lines. Cost:
// linear in the triples, of which no more than 2000 are used. Reference: Hartley & Zisserman, 2nd
// ed., 12.3, 15.
#ifndef EGOSIEVE_VISION_EVIDENCE_THREE_VIEW_H_
#define EGOSIEVE_VISION_EVIDENCE_THREE_VIEW_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"

namespace egosieve::vision {

// One scene point in three frames, pixels.
struct PointTriple {
  Eigen::Vector2d a, b, c;
};

struct ThreeViewOptions {
  int64_t max_triples = 2000;  // spread evenly over those given; at least 20
  int iterations = 6;          // positive

  absl::Status Validate() const;
};

struct ThreeViewMotion {
  bool found = false;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // R, b to c
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   // tau, units of |t_ab|
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  // P: (w, dtau)
  RelativePose base_to_first;                                                    // b to a
  double noise_pixels = 0.0;                                                     // sigma
  double scale = 1.0;        // m: residuals over those predicted by (V2); 1 if sigma is right
  double speed_ratio = 1.0;  // |tau|
};

// first: pose a to b; second: pose b to c.
ThreeViewMotion FitThreeViews(const std::vector<PointTriple>& triples, const RelativePose& first,
                              const RelativePose& second, const Pinhole& camera,
                              const ThreeViewOptions& options);

struct ThreeViewResidual {
  bool present = false;
  double along_pixels = 0.0;                            // z
  double deviation_pixels = 0.0;                        // with (V3) and m
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  // u / |u|
};

ThreeViewResidual MeasureThreeViews(const ThreeViewMotion& motion, const Pinhole& camera,
                                    const PointTriple& triple);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_THREE_VIEW_H_
