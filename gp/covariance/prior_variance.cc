#include "gp/covariance/prior_variance.h"

#include <cmath>

namespace egosieve::gp {

double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x) {
  const double signal_variance = covariance.signal_stddev * covariance.signal_stddev;
  if (covariance.function == kernels::CovarianceFunction::kSquaredExponential) {
    return signal_variance;
  }
  const std::vector<double>& w = covariance.scales;
  double sum = w[0] * w[0];
  for (size_t d = 1; d < w.size(); ++d) sum += w[d] * w[d] * x[d - 1] * x[d - 1];
  // asin(z) = atan(z / sqrt(1 - z^2)); with z = s / (1 + s), 1 - z^2 = (1 + 2 s) / (1 + s)^2: no
  // cancellation where z is near 1.
  const double s = 2.0 * sum;
  return signal_variance * std::atan(s / std::sqrt(1.0 + 2.0 * s));
}

}  // namespace egosieve::gp
