// The camera's rotation and its direction of travel between two frames, from the fundamental matrix
// and a guess of the focal length.
//
//   X_2 = R X_1 + t,  |t| = 1,   E = [t]x R ~ K^T F K                                       (P1)
//   E = U diag(1,1,0) V^T,   R = U W V^T or U W^T V^T,   t = +-U e_3                        (P2)
//   of the four the one with most points of significant parallax before both cameras        (P3)
//   minimise  sum_i rho(d_i / sigma)  over R (3) and t (2)                                  (P4)
//   covariance  sigma^2 (J^T W J)^-1                                                        (P5)
//   (P4), (P5) again, without the points that are significantly behind a camera             (P6)
//   dw/dlog f = -((J^T W J)^-1 J^T W dd/dlog f)_w     what another focal length does to R   (P7)
//
// with Sampson's distance d, rho of Cauchy, sigma the scale of residual_scale.h. Rotations above
// 90 degrees are rejected in (P3): they belong to the twisted pairs of small rotations. (P4) fits
// the pose to the guessed focal length. R and t absorb the error of the guess, so that the flow
// they predict hardly depends on it as long as the camera hardly turns. In sharp turns it does, as
// (P7) describes.
//
// The translation is significant if the parallax is: at least the share `parallax_share` of the
// inliers moves along the epipolar line, relative to the point at infinity, by more than the root
// of the sum of two squares: `parallax_multiple` sigma, and `lens_multiple` times the effect of one
// deviation of f (negative_depth.h, N4). If it is not (camera at rest, turning on the spot, distant
// or flat scene), t is meaningless, and so would be every depth.
//
// Cost: linear in the pairs, of which no more than 2000 are used.
// References: Hartley & Zisserman, 2nd ed., 9.6; Nister (2004).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/epipolar_line.h"
#include "vision/evidence/pinhole.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct RelativePoseOptions {
  int64_t max_pairs = 2000;         // spread evenly over the pairs given; at least 20
  int iterations = 8;               // of (P4); 0 keeps (P2)
  double noise_floor_pixels = 0.1;  // of sigma; positive
  double parallax_share = 0.25;     // (0, 1)
  double parallax_multiple = 5.0;   // positive
  double lens_multiple = 2.0;       // not negative
  double cheirality_margin = 0.6;   // least share of points in front in (P3); [0.5, 1]
  // Deviation of log f: fields of view are 40 to 100 degrees, the guess is 58. Not negative; 0: f
  // is known.
  double focal_deviation = 0.4;

  absl::Status Validate() const;
};

enum class PoseOutcome {
  kFound,
  kUndetermined,        // fewer than 20 inliers, or a rotation that is too uncertain
  kNoTranslation,       // parallax not significant
  kAmbiguousDirection,  // (P3) undecided
};

const char* Name(PoseOutcome outcome);

struct RelativePose {
  PoseOutcome outcome = PoseOutcome::kUndetermined;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // R
  Eigen::Vector3d translation = Eigen::Vector3d::UnitZ();  // t, unit
  Eigen::Matrix3d rotation_covariance =
      Eigen::Matrix3d::Zero();  // of w in R' = exp(w) R, radians^2
  // (P7) and the deviation of log f. Used for the pair's own evidence; not stored in states.
  Eigen::Vector3d rotation_by_focal = Eigen::Vector3d::Zero();
  double focal_deviation = 0.0;
  double noise_pixels = 0.0;     // sigma
  double parallax_pixels = 0.0;  // exceeded by parallax_share of the points

  bool found() const { return outcome == PoseOutcome::kFound; }
};

// fundamental: pixels, first frame to second. `options` must be valid.
RelativePose EstimateRelativePose(const std::vector<PointPair>& pairs,
                                  const Eigen::Matrix3d& fundamental, const Pinhole& camera,
                                  const RelativePoseOptions& options);

// ds/dlog f of a point's signed flow, pixels (negative_depth.h, N4). line: that of the pose.
double FlowByFocal(const Pinhole& camera, const RelativePose& pose, const EpipolarLine& line);

// K^-T [t]x R K^-1, unit Frobenius norm.
Eigen::Matrix3d FundamentalOfPose(const RelativePose& pose, const Pinhole& camera);

// From the second frame to the first; without covariance and effect of the focal length.
RelativePose Inverse(const RelativePose& pose);

// exp of the cross product matrix of w (Rodrigues).
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& w);

}  // namespace egosieve::vision
