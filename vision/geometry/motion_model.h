// Which model explains the camera's own motion between two frames, and that model.
//
// A fundamental matrix can explain whatever a homography can and more: with little parallax it
// bends to explain the moving objects too. So models are weighed by Torr's criterion (GRIC; Torr,
// 1998), which charges for the dimension d of what a model leaves free and for its k parameters:
//
//   GRIC = sum_i min(e_i^2 / sigma^2, 4 - (d - 2) log 4) + n d log 4 + k log 4 n (GR1)
//
//   static        d = 2, k = 0        e = |x2 - x1| / sqrt 2
//   homography    d = 2, k = 8        e = transfer error / sqrt 2
//   fundamental   d = 3, k = 7        e = Sampson's distance
//
// Torr's bound on the first term is 2 (4 - d); this one makes an outlier cost the same under each
// model, so that movers, which are outliers to all of them, do not weigh in the choice. With noise
// s in every coordinate all three have E e^2 = (4 - d) s^2: the transfer error lies in one image
// and carries the noise of both, hence the root. sigma is gric_sigma_pixels, or the noise itself
// where that is more: 1.48 times the median of Sampson's distance to F.
//
// The weights w_i, of mean 1, give equal areas of the image an equal say (12 x 6 cells): the
// distance, which a homography explains, is where most pairs survive at speed.
//
// The least is chosen; of the static model and the homography the simpler where they are equal.
// There is one case that (GR1) cannot tell: a camera that stands among things that all move along
// parallel lines sees what a camera that moves along these lines past things of different depth
// sees, but for this: with a camera that moves, hardly anything stays where it was. So
//
//   sum_i w_i [ |x2 - x1| < still_pixels ] >= still_share n  =>  static                    (GR2)
//
// From a moving car or hand a quarter of the image stays within 1/4 pixel at most.
//
// Measured and left out, on 328 frames of hand-held video and of drives: averaging GRIC over
// frames, with weights from 0.8 down to 0.1, changed not one choice (the criteria lie 0.25 a pair
// apart at least); and a robust quadratic flow in place of the homography gained 0.003 in AUC in
// the hand and is 0.01 to 0.25 below F on drives.
//
// Trust. A majority is what tells the camera's motion from an object's, so the model is believed
// where at least `minimum_support` of the pairs lie within `support_pixels` of it.
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

// kCalibrated: two_view_motion.h; EstimateMotionModel takes it for kAuto.
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
  double static_gric = 0.0, homography_gric = 0.0,
         fundamental_gric = 0.0;  // per pair; 0: not tried
  // The likeliest model of the other kind, two-dimensional or fundamental; kNone where there is
  // none.
  MotionModelKind rejected_kind = MotionModelKind::kNone;
  Eigen::Matrix3d rejected_matrix = Eigen::Matrix3d::Identity();
  // Median transfer error of the best homography: what the homography leaves unexplained is
  // parallax. 0 where no homography was tried.
  double parallax_pixels = 0.0;
  bool trusted = false;
  std::string reason;  // why it is not trusted, or why there is none
};

// Too few or degenerate pairs give kind kNone with a reason; an error means invalid options only.
absl::StatusOr<MotionModel> EstimateMotionModel(const std::vector<PointPair>& pairs,
                                                const MotionModelOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_GEOMETRY_MOTION_MODEL_H_
