// Covariance functions, matrices and gradients in plain float64: the reference of every test and
// the device "reference".
//
// The formulas are those of the functions in kernels/covariance, on prepared points
// (kernels/base/prepared_points.h). Cost: O(n m D). Arguments must be valid: the public operations
// check them.
#pragma once

#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels::reference {

// k(x, z) for points of D values each.
double Covariance(const CovarianceParameters& parameters, const double* x, const double* z);

// C(i, j) = k(x_i, z_j); with `lower_only` only j <= i. out: x.rows x z.rows.
void CovarianceBlock(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                     ConstMatrixView<double> z, bool lower_only, MatrixView<double> out);

// g_t = sum_ij W_ij dk(x_i, z_j) / d log theta_t, theta = (scales..., sigma_f); dk/dlog sigma_f = 2
// k. w: x.rows x z.rows; with `lower_only` z is x, and W symmetric with the lower triangle read.
std::vector<double> CovarianceGradient(const CovarianceParameters& parameters,
                                       ConstMatrixView<double> x, ConstMatrixView<double> z,
                                       ConstMatrixView<double> w, bool lower_only);

// g_t = sum_i w_i dk(x_i, x_i) / d log theta_t; w: x.rows values.
std::vector<double> VarianceGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, const double* w);

}  // namespace egosieve::kernels::reference
