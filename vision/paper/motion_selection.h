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
// image and has the noise of both, hence the root. sigma is 1 pixel, or the noise itself if
// that is larger: 1.48 times the median of Sampson's distance to F.
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
//   sum_i w_i [ |x2 - x1| < 0.25 px ] >= 0.4 n  =>  static                    (GR2)
//
// Trust. Only a large share of the pairs distinguishes the camera's motion from an object's. So the
// model is trusted if at least 0.3 of the pairs lie within 2 pixels of it.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// Too few or degenerate pairs give kind kNone with a reason.
absl::StatusOr<MotionModel> SelectMotion(const std::vector<PointPair>& pairs, uint64_t seed);
// The fundamental matrix alone, as in the paper, with the same trust.
absl::StatusOr<MotionModel> FitFundamental(const std::vector<PointPair>& pairs, uint64_t seed);

}  // namespace egosieve::vision
