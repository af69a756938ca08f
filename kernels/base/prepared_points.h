// Points in the coordinates in which their covariances are cheap and accurate.
//
// Arcsine: x~ = (1, x), a = sqrt(2) diag(w) x~, and, normalised once in float64,
//
//   (1) a^ = a / sqrt(1 + a.a),   e = 1 / (1 + a.a),   so that  a^.a^ + e = 1
//
// With z = a^.b^, s = sign z and |a^|^2 = 1 - e_a, |b^|^2 = 1 - e_b:
//
//   (2) |a^ - s b^|^2 = 2 - e_a - e_b - 2 |z|,  hence  h = (1 - |z|) / 2 = (|a^ - s b^|^2 + e_a +
//   e_b) / 4 (3) asin z = s (pi/2 - 2 asin sqrt(h)),  0 <= h <= 1/2
//
// Nothing cancels in (2): the sum has no negative term, and the error of a^ - s b^ from rounding a^
// and b^ to a unit roundoff u is at most u (|a^| + |b^|) <= 2u in norm, so sqrt(h) carries at most
// u, and asin z, whose derivative by sqrt(h) is at most 2 / sqrt(1 - h) <= 2.83, at most 2.83 u
// plus the rounding of the sum and of the polynomial. The halves a^/2 and quarters e/4 are what is
// stored: then h is a plain sum of squares.
//
// Squared exponential: x_d / l_d, and e = 0.
#ifndef EGOSIEVE_KERNELS_BASE_PREPARED_POINTS_H_
#define EGOSIEVE_KERNELS_BASE_PREPARED_POINTS_H_

#include <cstdint>

#include "kernels/base/covariance_parameters.h"

namespace egosieve::kernels {

// Coordinates of a prepared point, `e` not counted: D + 1 for the arcsine, else D.
inline int64_t PreparedComponents(const CovarianceParameters& parameters) {
  return static_cast<int64_t>(parameters.scales.size());
}

// Writes the components of the point x (D values): a^_c / 2 (or x_d / l_d) to out[c * step] and e /
// 4 (or 0) to out[components * step]. Output type Real is float or double; the arithmetic is
// float64.
template <typename Input, typename Real>
void PreparePoint(const CovarianceParameters& parameters, const Input* x, Real* out, int64_t step);

// The h = (1 - |z|) / 2 from which on the float32 arcsine may take z from the dot product of c
// components.
//
// Its error, u = 2^-24: 2 u from rounding the vectors, ceil(c / 2) u from the longer of two chains
// of multiply-adds, u from their sum; asin multiplies it by 1 / (2 sqrt(h (1 - h))), and the root,
// the polynomial and pi/2 add at most 1.5e-7. So
//
//   (ceil(c / 2) + 3) u / (2 sqrt(h (1 - h))) + 1.5e-7 <= 1e-6
//
// holds from the smaller root of h (1 - h) = s^2, s = (ceil(c / 2) + 3) u / 1.7e-6, on. 1, which no
// h reaches, when s > 1/2.
double DifferenceThreshold(int64_t components);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_PREPARED_POINTS_H_
