// The prior variance of f, k(x, x), in float64.
#ifndef EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_
#define EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// x: D values; `covariance` valid.
double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x);

// The largest at the points x, n x D; sigma_f^2 without points.
double LargestPriorVariance(const kernels::CovarianceParameters& covariance,
                            kernels::ConstMatrixView<double> x);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_COVARIANCE_PRIOR_VARIANCE_H_
