#include "gp/covariance/prior_variance.h"

namespace egosieve::gp {

double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x) {
  return covariance.signal_stddev * covariance.signal_stddev *
         covariance.function.description().Variance(covariance.scales.data(),
                                                    covariance.input_dimension(), x);
}

}  // namespace egosieve::gp
