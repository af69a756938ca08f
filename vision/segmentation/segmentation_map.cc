#include "vision/segmentation/segmentation_map.h"

#include <cmath>

namespace egosieve::vision {
namespace {

// Mean size of a mover, share of the picture (docs/constants.md).
constexpr double kMoverShare = 0.03;

}  // namespace

double ExpectedOverlap(const std::vector<float>& probability) {
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
