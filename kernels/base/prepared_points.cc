#include "kernels/base/prepared_points.h"

#include <algorithm>
#include <cmath>

namespace egosieve::kernels {
namespace {

// Keeps h positive in float32 where weights are so large that e would underflow; sqrt(h) moves by
// at most 1e-15.
constexpr double kSmallestQuarter = 1e-30;

}  // namespace

template <typename Input, typename Real>
void PreparePoint(const CovarianceParameters& parameters, const Input* x, Real* out, int64_t step) {
  const int64_t components = PreparedComponents(parameters);
  const double* scales = parameters.scales.data();
  if (parameters.function == CovarianceFunction::kSquaredExponential) {
    for (int64_t d = 0; d < components; ++d) {
      out[d * step] = static_cast<Real>(static_cast<double>(x[d]) / scales[d]);
    }
    out[components * step] = Real{0};
    return;
  }
  double half_norm = scales[0] * scales[0];  // a.a / 2
  for (int64_t d = 1; d < components; ++d) {
    const double a = scales[d] * static_cast<double>(x[d - 1]);
    half_norm += a * a;
  }
  const double e = 1.0 / (1.0 + 2.0 * half_norm);
  const double factor = std::sqrt(0.5 * e);  // sqrt(2) / (2 sqrt(1 + a.a))
  out[0] = static_cast<Real>(factor * scales[0]);
  for (int64_t d = 1; d < components; ++d) {
    out[d * step] = static_cast<Real>(factor * (scales[d] * static_cast<double>(x[d - 1])));
  }
  out[components * step] = static_cast<Real>(std::max(0.25 * e, kSmallestQuarter));
}

double DifferenceThreshold(int64_t components) {
  const int64_t roundings = (components + 1) / 2 + 3;  // in the longer of two chains
  const double s = static_cast<double>(roundings) * std::ldexp(1.0, -24) / 1.7e-6;
  return s < 0.5 ? 0.5 - std::sqrt(0.25 - s * s) : 1.0;
}

template void PreparePoint<double, double>(const CovarianceParameters&, const double*, double*,
                                           int64_t);
template void PreparePoint<double, float>(const CovarianceParameters&, const double*, float*,
                                          int64_t);
template void PreparePoint<float, double>(const CovarianceParameters&, const float*, double*,
                                          int64_t);
template void PreparePoint<float, float>(const CovarianceParameters&, const float*, float*,
                                         int64_t);

}  // namespace egosieve::kernels
