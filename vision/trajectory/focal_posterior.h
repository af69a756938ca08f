// One focal length for a drive, from pairs of pictures, as a distribution.
//
// Candidates are f_k = L exp(x_k), L the image's longer side, x_k evenly spaced from log 0.25 to
// log 4: 0.31 apart, less than the prior's deviation. A pair of pictures raises each by its
// log-likelihood,
//
//   log w_k <- log w_k + c (l_k - max_j l_j)                                              (FP1)
//   log w_k  = -(x_k - log 0.7)^2 / (2 0.4^2)     before any pair                         (FP2)
//
// l_k is that of two_view_motion.h (TV6), the motion fitted anew for every candidate, and c the
// number of independent points that a pair counts for. Points of one pair share the errors of flow
// and of the model, so c is small: a drive straight ahead leaves the prior as it is, a turn moves
// it. The estimate is exp of the mean of x. The prior holds dash-cams (0.4 to 0.65), KITTI (0.58),
// phones (0.7 to 0.8) and camcorders (0.8 to 1.5).
//
// Reference: Hartley & Zisserman, 2nd ed., 19.3, on what rotation tells about the focal length.
#ifndef EGOSIEVE_VISION_TRAJECTORY_FOCAL_POSTERIOR_H_
#define EGOSIEVE_VISION_TRAJECTORY_FOCAL_POSTERIOR_H_

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/point_pair.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

inline constexpr int kFocalCandidates = 10;

struct FocalPosterior {
  std::array<double, kFocalCandidates> log_weights;

  FocalPosterior();
  // (FP1). motion: that of the pairs under `camera`; nothing is learnt where it was not found.
  void Observe(const std::vector<PointPair>& pairs, const Pinhole& camera,
               const TwoViewMotion& motion, cv::Size image);

  // Focal length over the image's longer side, and the deviation of its logarithm.
  double Estimate() const;
  double LogDeviation() const;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_FOCAL_POSTERIOR_H_
