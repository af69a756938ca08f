// The density of an exponential variable with added Gaussian noise: the parallax of a static point
// whose inverse depth has an exponential distribution.
//
//   f(s) = integral_0^inf N(s; x, sigma^2) exp(-x / m) / m dx
//        = exp(k^2 / 2 - s / m) Phi(a) / m,   k = sigma / m,  a = s / sigma - k            (PP1)
//   (log f)'  = -1 / m + q / sigma,           q = phi(a) / Phi(a)                          (PP2)
//   (log f)'' = -q (q + a) / sigma^2                                                       (PP3)
//
// log f is concave in s. With E(x) = exp(x^2) erfc(x) and x = |a| / sqrt 2, Phi(-|a|) is
// E exp(-a^2 / 2) / 2, so that for a < 0
//
//   log f = -log m - s^2 / (2 sigma^2) + log(E / 2),   q = sqrt(2 / pi) / E                (PP4)
//
// without cancellation. Several values of s are evaluated together to fill vector registers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>

namespace egosieve::vision {

template <int kLanes>
using Lanes = Eigen::Array<double, kLanes, 1>;

template <int kLanes>
struct ParallaxDensity {
  Lanes<kLanes> log_density;
  Lanes<kLanes> slope;      // (PP2)
  Lanes<kLanes> curvature;  // minus (PP3), not negative
};

// E(x) for x >= 0, accurate to 1e-14: (1 + 2 x) E(x) as a polynomial in (x - 3) / (x + 3),
// interpolated at Chebyshev points, after Shepherd & Laframboise, Mathematics of Computation 36
// (1981).
template <int kLanes>
Lanes<kLanes> ScaledErfc(const Lanes<kLanes>& x) {
  constexpr std::array kCoefficients = {
      1.2530080582697296,     -0.13562110612441822,    -0.04756229435337362,
      0.12964515869079063,    -0.11927366342098462,    0.06830802760354795,
      -0.02377051479516874,   0.0025293892281577058,   0.0018886891214380532,
      -0.0007798180426686765, -0.00010515293761186614, 0.00012505210902277983,
      4.926426199273504e-06,  -2.0001593210484034e-05, -6.823639161720932e-07,
      3.3400344204087884e-06, 2.8943446741065843e-07,  -5.058347470958459e-07,
      -8.297479225555304e-08, 4.747686809676856e-08,   1.1141772012143352e-08};
  const Lanes<kLanes> t = (x - 3.0) / (x + 3.0);
  Lanes<kLanes> sum = Lanes<kLanes>::Constant(kCoefficients.back());
  for (int k = static_cast<int>(kCoefficients.size()) - 2; k >= 0; --k) {
    sum = sum * t + kCoefficients[k];
  }
  return sum / (1.0 + 2.0 * x);
}

// mean, deviation: m and sigma, positive; the deviation is a number or Lanes<kLanes>. log_density
// has a relative accuracy of 1e-9.
template <int kLanes, typename Deviation>
ParallaxDensity<kLanes> EvaluateParallax(const Lanes<kLanes>& s, const Lanes<kLanes>& mean,
                                         const Deviation& deviation) {
  constexpr double kInverseSqrtTwoPi = std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  const Lanes<kLanes> k = deviation / mean, z = s / deviation, a = z - k;
  const Lanes<kLanes> e = ScaledErfc<kLanes>(a.abs() / std::numbers::sqrt2);
  const Lanes<kLanes> density_of_a = kInverseSqrtTwoPi * (-0.5 * a * a).exp();
  const Lanes<kLanes> below = e * density_of_a / (2.0 * kInverseSqrtTwoPi);  // Phi(-|a|)
  const Eigen::Array<bool, kLanes, 1> is_tail = a < 0.0;
  const Lanes<kLanes> ratio =
      is_tail.select(2.0 * kInverseSqrtTwoPi / e, density_of_a / (1.0 - below));
  const Lanes<kLanes> argument = is_tail.select(0.5 * e, 1.0 - below);
  ParallaxDensity<kLanes> density;
  density.log_density =
      (argument / mean).log() + is_tail.select(-0.5 * z * z, 0.5 * k * k - s / mean);
  density.slope = ratio / deviation - 1.0 / mean;
  density.curvature = (ratio * (ratio + a)).max(0.0) / (deviation * deviation);
  return density;
}

}  // namespace egosieve::vision
