// Selects the model that explains the camera's motion between two frames, and estimates it.
//
// A fundamental matrix explains everything that a homography explains, and more: with little
// parallax it also adapts to moving objects. So models are compared by Torr's criterion (GRIC;
// Torr, 1998), which penalises the dimension d of the manifold of pairs that a model allows, and
// its number k of parameters:
//
//   GRIC = sum_i w_i min(e_i^2 / sigma^2, 4 - (d - 2) log 4) + n d log 4 + k log 4 n       (GR1)
//
//   static        d = 2, k = 0        e = |x2 - x1| / sqrt 2
//   homography    d = 2, k = 8        e = transfer error / sqrt 2
//   fundamental   d = 3, k = 7        e = Sampson's distance
//
// Torr's bound on the first term is 2 (4 - d). With this one an outlier costs the same under each
// model, so that movers, which are outliers to all of them, do not affect the choice. With noise s
// in every coordinate all three have E e^2 = (4 - d) s^2: the transfer error is measured in one
// image and has the noise of both, hence the root. sigma is gric_sigma_pixels, or the noise itself
// if that is larger: 1.48 times the median of Sampson's distance to F.
//
// The weights w_i, of mean 1, give equal areas of the image equal weight (12 x 6 cells). Otherwise
// the far distance, which a homography explains, would dominate, since most pairs survive there at
// speed.
//
// The model with the smallest GRIC is chosen; if the static model and the homography are equal, the
// simpler one. (GR1) cannot distinguish one case: a static camera among objects that all move along
// parallel lines sees the same as a camera that moves along these lines past objects of different
// depth. The difference is that with a moving camera hardly any point keeps its position in the
// image. So
//
//   sum_i w_i [ |x2 - x1| < still_pixels ] >= still_share n  =>  static                    (GR2)
//
// Trust. Only a large share of the pairs distinguishes the camera's motion from an object's. So the
// model is trusted if at least `minimum_support` of the pairs lie within `support_pixels` of it.
#ifndef EGOSIEVE_VISION_GEOMETRY_MOTION_MODEL_H_
#define EGOSIEVE_VISION_GEOMETRY_MOTION_MODEL_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/geometry/motion_model_kind.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// kCalibrated: two_view_motion.h; EstimateMotionModel treats it like kAuto.
enum class MotionModelChoice { kAuto, kFundamental, kHomography, kCalibrated };

struct MotionModelOptions {
  MotionModelChoice choice = MotionModelChoice::kAuto;
  double fundamental_threshold_pixels = 0.25;  // RANSAC's T for F; positive
  double homography_threshold_pixels = 1.0;    // RANSAC's T for H; positive
  double gric_sigma_pixels = 1.0;              // sigma in (GR1); positive
  double still_pixels = 0.25;                  // in (GR2); positive
  double still_share = 0.4;                    // in (GR2); [0, 1]
  double support_pixels = 2.0;                 // positive
  double minimum_support = 0.3;                // share of pairs, [0, 1]
  uint64_t seed = 1;

  absl::Status Validate() const;
};

struct MotionModel {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // H or F in pixels, first image to second
  int64_t inlier_count = 0;                              // pairs within support_pixels
  int64_t pair_count = 0;
  // The competing model of the other kind, two-dimensional or fundamental; of two-dimensional ones
  // the homography if there is one. kNone without such a model.
  MotionModelKind rejected_kind = MotionModelKind::kNone;
  Eigen::Matrix3d rejected_matrix = Eigen::Matrix3d::Identity();
  // Median transfer error of the best homography, which measures parallax: the motion that the
  // homography does not explain. 0 where no homography was tried.
  double parallax_pixels = 0.0;
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

// Too few or degenerate pairs give kind kNone with a reason. An error means invalid options.
absl::StatusOr<MotionModel> EstimateMotionModel(const std::vector<PointPair>& pairs,
                                                const MotionModelOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_GEOMETRY_MOTION_MODEL_H_
