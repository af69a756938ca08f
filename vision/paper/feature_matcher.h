// Matches between the features of two frames.
//
//   the nearest by descriptor (descriptor_search.h), kept where
//     d1 < 0.8 d2         the nearest is clearly nearer than the second (Lowe, 2004)
//     mutual              each is the other's nearest
//
// Key points and corners are matched separately.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/paper/feature_set.h"

namespace egosieve::vision {

struct Match {
  int32_t first = 0;   // index into the first frame's features
  int32_t second = 0;  // index into the second frame's features
};

// In increasing order of `first`. The result does not depend on `threads`.
std::vector<Match> MatchFeatures(const FeatureSet& first, const FeatureSet& second, int threads);

}  // namespace egosieve::vision
