// The derivative of sum_ij W_ij k(x_i, x_j) with respect to the logarithm of every covariance
// parameter, in one pass over (i, j), without a matrix of derivatives.
//
//   g_t = sum_ij W_ij dk(x_i, x_j) / d log theta_t,   theta = (scales..., sigma_f)
//
// With W = alpha alpha^T - K^-1, g / 2 is the gradient of the log marginal likelihood (Rasmussen &
// Williams, eq. 5.9). The noise variance is not part of k; the caller adds its term.
//
// CrossCovarianceGradient is the same between two sets, and VarianceGradient for variances alone:
//
//   g_t = sum_ij W_ij dk(x_i, z_j) / d log theta_t,   g_t = sum_i w_i dk(x_i, x_i) / d log theta_t
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// x: n x D; w: n x n, symmetric; only the lower triangle is read. Returns scales.size() + 1 values,
// accumulated in float64.
absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> w);

// x: n x D; z: m x D; w: n x m, all of it read.
absl::StatusOr<std::vector<double>> CrossCovarianceGradient(Context& context,
                                                            const CovarianceParameters& parameters,
                                                            ConstMatrixView<double> x,
                                                            ConstMatrixView<double> z,
                                                            ConstMatrixView<double> w);

// x: n x D; weights: n values. On the host.
absl::StatusOr<std::vector<double>> VarianceGradient(const CovarianceParameters& parameters,
                                                     ConstMatrixView<double> x,
                                                     absl::Span<const double> weights);

}  // namespace egosieve::kernels
