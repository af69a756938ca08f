// The mean of a Gaussian process. Its coefficients b are determined by the data.
//
//   y = h(x).b + f(x) + noise,   f ~ GP(0, k)                                               (1)
//
//   zero       h = ()       q = 0
//   constant   h = (1)      q = 1
//   linear     h = (1, x)   q = D + 1
//
// b has no prior (Rasmussen & Williams (2006), 2.7, the limit of a vague prior): it is estimated by
// generalised least squares, and predictions include its uncertainty. In geostatistics this is
// simple, ordinary and universal kriging.
#pragma once

#include <algorithm>
#include <cstdint>

namespace egosieve::gp {

enum class MeanFunction { kZero = 0, kConstant = 1, kLinear = 2 };

// q for D inputs.
inline int64_t CoefficientCount(MeanFunction mean, int64_t dimension) {
  return mean == MeanFunction::kZero ? 0 : mean == MeanFunction::kConstant ? 1 : dimension + 1;
}

// h(x), q values.
template <typename Input>
void EvaluateBasis(MeanFunction mean, int64_t dimension, const Input* x, double* h) {
  if (mean == MeanFunction::kZero) return;
  h[0] = 1.0;
  if (mean == MeanFunction::kLinear) std::copy_n(x, dimension, h + 1);
}

}  // namespace egosieve::gp
