// Log-likelihood ratios from several pairs of pictures under calibrated camera motions.
//
// Each pair of pictures gives each place a log-likelihood ratio l of moving against static
// (two_view_motion.h, TV4, TV5 and TV8). A positive l is limited by the ratio of the grey levels
// (photometric_support.h, S2). The pairs are not independent: a slow mover is far from its epipolar
// line after half a second, and hardly off it after one picture. The small offset is not evidence
// against motion. So the pair with the longest time span is evaluated first. Its offset c_1 from
// the line over n_1 pictures predicts the offset of a mover of constant velocity over n_2 pictures:
//
//   m = n_2 / n_1 (c_1 v_1) . v_2,   s^2 = (n_2 / n_1)^2 (sigma_1^2 + |c_1|^2 / 4)          (CP1)
//
// v_1 and v_2 are the normals of the lines. s allows the speed to change by half. Movers of this
// velocity and movers of any other, for which l holds, have equal prior probability:
//
//   l_2 = log( exp(l) / 2 + N(c_2; m, sigma_2^2 + s^2) / p(c_2) / 2 )                       (CP2)
//
// with p of a static place: N(c_2; 0, sigma_2^2), or (SX2) of scatter.h where it scatters.
// For a static point l_2 is about 0, so that it is not counted twice.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/photometric_support.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Two pictures and the positions of the same points in both.
struct CalibratedPair {
  TwoViewMotion motion;  // first to second
  int pictures = 1;      // from first to second; negative: the second is the earlier one; not 0
  std::vector<PointPair> places;              // pixels; NaN where not known
  std::optional<PhotometricSupport> support;  // nullopt: grey levels do not limit l
};

// l of each pair for each place, within +-12; nullopt where the place is NaN. All pairs must have
// the same number of places. is_unbounded: one per place, true: the ground bound (ground_bound.h)
// is not applied; empty: it is applied to all.
std::vector<std::vector<std::optional<double>>> CalibratedLogRatios(
    const std::vector<CalibratedPair>& pairs, const Pinhole& camera,
    const std::vector<bool>& is_unbounded = {});

}  // namespace egosieve::vision
