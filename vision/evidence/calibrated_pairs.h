// What several pictures say of the places of one, under calibrated motions.
//
// Each pair of pictures gives a place a log-likelihood ratio l of moving against static
// (two_view_motion.h, TV4 and TV5), where it says "moving" no more than the pictures themselves do
// (photometric_support.h, S2). The pairs are not independent: what moves slowly is far off its
// epipolar line c after half a second and hardly after one picture, and that the latter is small
// says nothing against its moving. So the pair with the longest time span is evaluated first. Its
// offset c_1 over n_1 pictures predicts that of a mover of constant velocity over n_2 pictures:
//
//   m = n_2 / n_1 (c_1 v_1) . v_2,   s^2 = (n_2 / n_1)^2 (sigma_1^2 + |c_1|^2 / 4)          (CP1)
//
// v the lines' normals; the deviation allows for half the speed. With the same weight the mover
// moves in any way:
//
//   l_2 = log( exp(l) / 2 + N(c_2; m, sigma_2^2 + s^2) / N(c_2; 0, sigma_2^2) / 2 )         (CP2)
//
// For a static point l_2 is about 0, so that it is not counted twice.
#ifndef EGOSIEVE_VISION_EVIDENCE_CALIBRATED_PAIRS_H_
#define EGOSIEVE_VISION_EVIDENCE_CALIBRATED_PAIRS_H_

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/photometric_support.h"
#include "vision/evidence/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Two pictures and where the places are in them.
struct CalibratedPair {
  TwoViewMotion motion;  // first to second
  int pictures = 1;      // from the first to the second; negative: it is before the first; not 0
  std::vector<PointPair> places;              // pixels; NaN where not known
  std::optional<PhotometricSupport> support;  // nothing: the pictures are not asked
};

// l of each pair for each place, within +-12; nothing where the pair does not know the place. All
// pairs must have the same number of places. is_unbounded: one a place, true without the ground's
// bound; empty: all are bounded.
std::vector<std::vector<std::optional<double>>> CalibratedLogRatios(
    const std::vector<CalibratedPair>& pairs, const Pinhole& camera,
    const std::vector<bool>& is_unbounded = {});

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_CALIBRATED_PAIRS_H_
