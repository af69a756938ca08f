// Derivatives of covariances with respect to the inputs.
//
//   g_i = sum_j W_ij dk(x_i, z_j) / dx_i                                                     (1)
//
// With W_ij = alpha_j, g_i is the gradient of a posterior's mean at x_i. At a cusp or step of a
// function (matern12 and white at x_i = z_j) the derivative is taken as 0.
//
// In float64 on the host, on several threads: m n D operations, little compared with the n^2 per x
// of a variance's gradient. The bits are the same for any number of threads.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels {

// x: m x D; z: n x D; w: m x n, or one row for all with a stride of 0; out: m x D. InvalidArgument,
// naming the argument, for invalid parameters, other shapes and inputs that are not finite.
absl::Status CovarianceInputGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, ConstMatrixView<double> z,
                                     ConstMatrixView<double> w, MatrixView<double> out);

// All derivatives of a block, where row i m + j is of k(x_i, z_j), x: n x D, z: m x D:
//   by_logarithms  (n m) x (scales + 1), by the logarithms of the scales and of sigma_f
//   by_input       (n m) x D, by x_i
// Without data: not wanted. InvalidArgument as above.
absl::Status CovarianceDerivatives(const CovarianceParameters& parameters,
                                   ConstMatrixView<double> x, ConstMatrixView<double> z,
                                   MatrixView<double> by_logarithms, MatrixView<double> by_input);

// dk(x, x) / dx; x and out: D values. `parameters` valid.
void PriorVarianceGradient(const CovarianceParameters& parameters, const double* x, double* out);

}  // namespace egosieve::kernels
