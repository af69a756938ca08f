// Distinguishes false matches from movers: a true match moves like its surroundings, which are
// static or an object. A false match has any direction.
//
//   i agrees where at least two other pairs j have
//     |x1_i - x1_j| <= 40 px   and   |d_i - d_j| <= 3 px + 0.15 |d_i|,   d = x2 - x1
//
// Cost: at most quadratic in the pairs, usually far less.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// One per pair, 1 where it agrees. Pairs that are not finite agree with none.
std::vector<uint8_t> AgreesWithNeighbours(const std::vector<PointPair>& pairs);

}  // namespace egosieve::vision
