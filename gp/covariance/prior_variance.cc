#include "gp/covariance/prior_variance.h"

#include <algorithm>

namespace egosieve::gp {

double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x) {
  return covariance.signal_stddev * covariance.signal_stddev *
         covariance.function.description().Variance(covariance.scales.data(),
                                                    covariance.input_dimension(), x);
}

double LargestPriorVariance(const kernels::CovarianceParameters& covariance,
                            kernels::ConstMatrixView<double> x) {
  if (x.rows == 0) return covariance.signal_stddev * covariance.signal_stddev;
  double largest = 0.0;
  for (int64_t i = 0; i < x.rows; ++i) {
    largest = std::max(largest, PriorVariance(covariance, x.row(i)));
  }
  return largest;
}

}  // namespace egosieve::gp
