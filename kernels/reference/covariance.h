// Covariance functions, matrices and gradients in plain float64: the oracle of every test and the
// device "reference".
//
// The formulas are those of kernels/base/covariance_parameters.h, evaluated as
// kernels/base/prepared_points.h says. Cost: O(n m D). Arguments are taken as valid: the public
// operations check them.
#ifndef EGOSIEVE_KERNELS_REFERENCE_COVARIANCE_H_
#define EGOSIEVE_KERNELS_REFERENCE_COVARIANCE_H_

#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels::reference {

// k(x, z) for points of D values each.
double Covariance(const CovarianceParameters& parameters, const double* x, const double* z);

// C(i, j) = k(x_i, z_j); with `lower_only` just j <= i. out: x.rows x z.rows.
template <typename T>
void CovarianceBlock(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                     ConstMatrixView<double> z, bool lower_only, MatrixView<T> out);

// g_t = sum_ij W_ij dk(x_i, x_j) / d log theta_t, theta = (scales..., sigma_f); W symmetric, lower
// triangle read.
//
//   arcsine             dk/dlog w_d = sigma_f^2 s (2 h (a^_d^2 + b^_d^2) - (a^_d - s b^_d)^2) /
//   sqrt(1 - z^2)
//                       1 - z^2 = 4 h (1 - h), h and s as in prepared_points.h
//   squared exponential dk/dlog l_d = k ((x_d - x'_d) / l_d)^2
//   both                dk/dlog sigma_f = 2 k
std::vector<double> CovarianceGradient(const CovarianceParameters& parameters,
                                       ConstMatrixView<double> x, ConstMatrixView<double> w);

}  // namespace egosieve::kernels::reference

#endif  // EGOSIEVE_KERNELS_REFERENCE_COVARIANCE_H_
