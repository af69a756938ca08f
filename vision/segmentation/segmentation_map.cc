#include "vision/segmentation/segmentation_map.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {

double ExpectedOverlap(const std::vector<float>& probability) {
  if (probability.empty()) return std::nan("");
  double intersection = 0.0, united = 0.0;
  for (const float p : probability) {
    if (p > 0.5f) intersection += p;
    united += p > 0.5f ? 1.0 : p;
  }
  if (intersection > 0.0) return intersection / united;
  return 1.0 - *std::max_element(probability.begin(), probability.end());
}

}  // namespace egosieve::vision
