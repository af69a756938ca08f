// The result for one frame: probability and uncertainty on a grid over its pixels.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "vision/image/image_grid.h"

namespace egosieve::vision {

// All vectors have grid.size() elements, row-major over the grid's rows and columns.
struct SegmentationMap {
  int64_t frame_index = 0;
  ImageGrid grid;
  std::vector<float> probability;  // of belonging to a mover
  std::vector<float> mean;         // of f, with labels -1 (static) and 1 (dynamic)
  std::vector<float> deviation;    // standard deviation of f
};

// The intersection over union of the mask p > 1/2 with the true one that the probabilities expect:
// of the expected intersection and union,
//
//   sum_{p > 1/2} p / (#{p > 1/2} + sum_{p <= 1/2} p);                                        (EO1)
//
// of a map without a mask, which is right if nothing moves, the probability of that,
//
//   exp(-mean p / 0.03),                                                                      (EO2)
//
// where movers fill 3 % of the picture each and their number has a Poisson distribution. NaN of an
// empty map.
inline double ExpectedOverlap(const std::vector<float>& probability) {
  constexpr double kMoverShare = 0.03;  // docs/constants.md
  if (probability.empty()) return std::nan("");
  double intersection = 0.0, united = 0.0;
  for (const float p : probability) {
    if (p > 0.5f) intersection += p;
    united += p > 0.5f ? 1.0 : p;
  }
  if (intersection > 0.0) return intersection / united;
  return std::exp(-united / (kMoverShare * static_cast<double>(probability.size())));  // (EO2)
}

}  // namespace egosieve::vision
