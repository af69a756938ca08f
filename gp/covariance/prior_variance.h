// The prior variance of f at a point, k(x, x), in float64.
#ifndef EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_
#define EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_

#include "kernels/base/covariance_parameters.h"

namespace egosieve::gp {

// x: D values; `covariance` valid.
double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_
