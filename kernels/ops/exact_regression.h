// Exact Gaussian process regression on the device, from points to the quantities that training
// needs:
//
//   L L^T = K + diag(noise_variance + v),   alpha = (L L^T)^-1 Y                             (1)
//   half_log_determinant = sum_i log L_ii,  fit = sum_ic Y_ic alpha_ic                       (2)
//   gradient_t = sum_ij (sum_c alpha_ic alpha_jc - k (K + ...)^-1_ij) dK_ij / d theta_t      (3)
//   trace = sum_i of the same weights (i, i)
//
// with Y of k outputs; (3) is that of kernels/ops/covariance_matrix.h, twice the gradient of the
// log marginal likelihood. Float64. Covariances, factor, inverse and weights stay in the device's
// memory, as two n x n arrays. The transfers are n (D + 2 k + 2) values to the device, and n (k +
// 2) and n / 4 per parameter back. Cost: n^3 / 3 flops, n^3 with the gradient
// (kernels/ops/device_linear_algebra.h counts them and the bytes), and one or two passes over the
// pairs.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

struct ExactRegression {
  int64_t bad_row = -1;  // whose pivot was refused (floor n eps K(i, i)); then all else is empty
  double half_log_determinant = 0.0;
  double fit = 0.0;
  std::vector<double> alpha;     // n x k
  std::vector<double> gradient;  // (3); empty if not requested
  double trace = 0.0;
};

// Whether to use the device: it has float64 and its own memory.
bool RegressesOnDevice(const Context& context);

// x: n x D; y: n x k, k >= 1; variances: n values of v; empty: all 0. InvalidArgument for other
// shapes and points or targets that are NaN or infinite; FailedPrecondition on devices without float64.
absl::StatusOr<ExactRegression> RegressOnDevice(Context& context,
                                                const CovarianceParameters& parameters,
                                                ConstMatrixView<double> x,
                                                ConstMatrixView<double> y, double noise_variance,
                                                absl::Span<const double> variances,
                                                bool with_gradient);

// The factor alone, for further use on the host: covariances, noise and n^3 / 3 flops on the
// device, n (2 D + 1) values to it and (n^2 + 256 n) / 2 back. x, noise_variance, variances and
// errors as above. Returns -1, and the lower triangle of `out`, n x n, is L; or the row whose pivot
// was refused, and `out` is unchanged. Elements above the diagonal are never changed. After a
// device error `out` may be partly written.
absl::StatusOr<int64_t> FactorizeOnDevice(Context& context, const CovarianceParameters& parameters,
                                          ConstMatrixView<double> x, double noise_variance,
                                          absl::Span<const double> variances,
                                          MatrixView<double> out);

}  // namespace egosieve::kernels
