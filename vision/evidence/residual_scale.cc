#include "vision/evidence/residual_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kCut = 2.5;
constexpr int kSteps = 5;

}  // namespace

double ResidualScale(std::vector<double> residuals, int dimensions, double floor) {
  std::erase_if(residuals, [](double r) { return !std::isfinite(r); });
  if (residuals.empty()) return floor;
  for (double& r : residuals) r = std::abs(r);
  const double median = MedianInPlace(residuals);
  const double median_of_unit = dimensions == 1 ? 0.6745 : 1.1774;
  const double variance_left = dimensions == 1 ? 0.9112 : 2 * 0.8564;
  double sigma = std::max(floor, median / median_of_unit);
  for (int k = 0; k < kSteps; ++k) {
    double sum = 0.0;
    int64_t count = 0;
    for (const double r : residuals) {
      if (!(r < kCut * sigma)) continue;
      sum += r * r;
      ++count;
    }
    if (count == 0) break;
    sigma = std::max(floor, std::sqrt(sum / (variance_left * static_cast<double>(count))));
  }
  return sigma;
}

}  // namespace egosieve::vision
