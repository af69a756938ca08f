// The prior variance of f, k(x, x), in float64.
#pragma once

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// x: D values; `covariance` valid.
double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x);

// The largest at the points x, n x D; sigma_f^2 without points.
double LargestPriorVariance(const kernels::CovarianceParameters& covariance,
                            kernels::ConstMatrixView<double> x);

}  // namespace egosieve::gp
