#include "vision/trajectory/parallax_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace egosieve::vision {
namespace {

// Below this argument Phi is taken from its continued fraction.
constexpr double kTail = -6.0;

// phi(a) / Phi(a) for a < kTail, by Laplace's continued fraction of the Mills ratio.
double TailRatio(double a) {
  double fraction = 0.0;
  for (int k = 24; k > 0; --k) fraction = k / (-a + fraction);
  return -a + fraction;
}

}  // namespace

ParallaxDensity EvaluateParallax(double s, double mean, double deviation) {
  static const double kLogSqrtTwoPi = 0.5 * std::log(2.0 * std::numbers::pi);
  const double k = deviation / mean;
  const double a = s / deviation - k;
  ParallaxDensity density;
  double ratio;
  if (a < kTail) {
    // k^2 / 2 - s / m - a^2 / 2 = -s^2 / (2 sigma^2), without the cancellation.
    const double z = s / deviation;
    ratio = TailRatio(a);
    density.log_density = -std::log(mean) - 0.5 * z * z - kLogSqrtTwoPi - std::log(ratio);
  } else {
    const double phi = 0.5 * std::erfc(-a / std::numbers::sqrt2);
    ratio = std::exp(-0.5 * a * a - kLogSqrtTwoPi) / phi;
    density.log_density = -std::log(mean) + 0.5 * k * k - s / mean + std::log(phi);
  }
  density.slope = -1.0 / mean + ratio / deviation;
  density.curvature = std::max(ratio * (ratio + a), 0.0) / (deviation * deviation);
  return density;
}

}  // namespace egosieve::vision
