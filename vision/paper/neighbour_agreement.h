// Distinguishes false matches from movers: a true match moves like its surroundings, which are
// static or an object. A false match has any direction.
//
//   i agrees where at least `minimum_neighbours` other pairs j have
//     |x1_i - x1_j| <= radius   and
//     |d_i - d_j| <= tolerance + tolerance_slope |d_i|,   d = x2 - x1
//
// Cost: linear in the pairs times the neighbours of each.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct NeighbourAgreementOptions {
  double radius_pixels = 40.0;    // positive
  double tolerance_pixels = 3.0;  // >= 0
  double tolerance_slope = 0.15;  // of the displacement; >= 0
  int minimum_neighbours = 2;     // >= 0
};

// One per pair, 1 where it agrees. Pairs that are not finite agree with none. `options` must be
// valid.
std::vector<uint8_t> AgreesWithNeighbours(const std::vector<PointPair>& pairs,
                                          const NeighbourAgreementOptions& options);

}  // namespace egosieve::vision
