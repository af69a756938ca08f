// The accuracy of the arcsine covariance in float32; the function itself needs no header.
#pragma once

#include <cstdint>

namespace egosieve::kernels {

// The smallest h = (1 - |z|) / 2 at which the float32 arcsine may take z from the dot product of c
// components.
//
// Error of the dot product, u = 2^-24: 2 u from rounding the vectors, ceil(c / 2) u from the longer
// of two chains of multiply-adds, u from their sum. asin multiplies it by 1 / (2 sqrt(h (1 - h)));
// the root, the polynomial and pi/2 add at most 1.5e-7. So
//
//   (ceil(c / 2) + 3) u / (2 sqrt(h (1 - h))) + 1.5e-7 <= 1e-6
//
// holds if h is at least the smaller root of h (1 - h) = s^2, s = (ceil(c / 2) + 3) u / 1.7e-6. For
// s > 1/2 the result is 1, which no h reaches.
double DifferenceThreshold(int64_t components);

}  // namespace egosieve::kernels
