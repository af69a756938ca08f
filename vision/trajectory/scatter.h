// How widely static places scatter around where the motion of a hand-held camera puts them.
//
// The deviation sigma is the median's; water, leaves, rolling shutters, and errors of lens and pose
// move some static places by many times as much. So the deviation of a place is s_k sigma, and
//
//   s_k = 3^k,   w_k proportional to s_k^-3,   k = 0 ... 3                                   (SX1)
//   p(c) = sum_k w_k N(c; 0, s_k^2 sigma^2)                                                  (SX2)
//
// Student's t with 3 degrees of freedom, whose tails fall as |c|^-4, is a mixture of this kind with
// a continuum of scales. Reference: Andrews & Mallows (1974), scale mixtures of normal
// distributions.
#pragma once

#include <cmath>
#include <numbers>

#include "vision/trajectory/parallax_prior.h"

namespace egosieve::vision {

inline constexpr int kScatterScales = 4;

inline Lanes<kScatterScales> ScatterScales() { return {1.0, 3.0, 9.0, 27.0}; }

// log sum_k w_k exp(log_densities_k)
inline double LogScatterMean(const Lanes<kScatterScales>& log_densities) {
  const Lanes<kScatterScales> weights = ScatterScales().cube().inverse();
  const double top = log_densities.maxCoeff();
  return top + std::log((weights * (log_densities - top).exp()).sum() / weights.sum());
}

inline double LogNormalDensity(double z) {
  return -0.5 * (z * z + std::log(2.0 * std::numbers::pi));
}

// log p(z) of (SX2) for sigma = 1.
inline double LogScatterDensity(double z) {
  const Lanes<kScatterScales> scales = ScatterScales();
  return LogScatterMean(-0.5 * (z / scales).square() - scales.log()) + LogNormalDensity(0.0);
}

}  // namespace egosieve::vision
