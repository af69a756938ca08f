// Covariance matrices of points, and the derivatives of covariances.
//
//   K_ij = k(x_i, x_j) + noise_variance [i = j]                CovarianceMatrix, n x n
//   C_ij = k(x_i, z_j)                                         CrossCovariance, n x m, in tiles
//   g_t = sum_ij W_ij dk(x_i, x_j) / d log theta_t             CovarianceGradient
//   g_t = sum_ij W_ij dk(x_i, z_j) / d log theta_t             CrossCovarianceGradient
//   g_t = sum_i w_i dk(x_i, x_i) / d log theta_t               VarianceGradient
//   g_i = sum_j W_ij dk(x_i, z_j) / dx_i                       CovarianceInputGradient
//
// with theta = (scales..., sigma_f), in one pass over (i, j), without a matrix of derivatives. With W
// = alpha alpha^T - K^-1, g_t / 2 is the gradient of the log marginal likelihood (Rasmussen &
// Williams, eq. 5.9). The noise variance is not part of k; the caller adds its term. With W_ij =
// alpha_j, g_i is the gradient of a posterior's mean at x_i. At a cusp or step of a function
// (matern12 and white at x_i = z_j) the derivative by x is taken as 0.
//
// InvalidArgument, naming the argument, for invalid parameters, other shapes and inputs that are not
// finite. After an error in the arguments, or a device error before the computation began, `out` is
// unchanged; after a device is lost during the computation `out` may be partly written.
//
// In float64; on a device without it they run on the host. VarianceGradient and derivatives by x
// always do, the latter on several threads: m n D operations, little compared with the n^2 per x of a
// variance's gradient. The bits are the same for any number of threads.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/device_call.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

enum class Triangle {
  kFull,
  kLower,  // elements above the diagonal stay unchanged
};

// x: n x D; out: n x n.
absl::Status CovarianceMatrix(Context& context, const CovarianceParameters& parameters,
                              ConstMatrixView<double> x, double noise_variance, Triangle triangle,
                              MatrixView<double> out);

// x: n x D; z: m x D; out: n x m.
absl::Status CrossCovariance(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z,
                             MatrixView<double> out);

// The same without waiting, in float64 from and to buffers of the context's OpenCL context: x, n x D,
// z, m x D, k, n x m. Inputs are not checked: NaN gives NaN. The caller releases the event, which
// completes with the last command; commands keep what they need. InvalidArgument for handles of
// other contexts and for buffers that are too small; FailedPrecondition on devices without float64
// and on "reference".
absl::StatusOr<cl_event> EnqueueCrossCovariance(std::shared_ptr<Context> context,
                                                const CovarianceParameters& parameters,
                                                const BufferMatrix& x, const BufferMatrix& z,
                                                const BufferMatrix& k, const DeviceCall& call);

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

// x: n x D; weights: n values.
absl::StatusOr<std::vector<double>> VarianceGradient(const CovarianceParameters& parameters,
                                                     ConstMatrixView<double> x,
                                                     absl::Span<const double> weights);

// x: m x D; z: n x D; w: m x n, or one row for all with a stride of 0; out: m x D.
absl::Status CovarianceInputGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, ConstMatrixView<double> z,
                                     ConstMatrixView<double> w, MatrixView<double> out);

// All derivatives of a block, where row i m + j is of k(x_i, z_j), x: n x D, z: m x D:
//   by_logarithms  (n m) x (scales + 1), by the logarithms of the scales and of sigma_f
//   by_input       (n m) x D, by x_i
// Without data: not wanted.
absl::Status CovarianceDerivatives(const CovarianceParameters& parameters,
                                   ConstMatrixView<double> x, ConstMatrixView<double> z,
                                   MatrixView<double> by_logarithms, MatrixView<double> by_input);

// dk(x, x) / dx; x and out: D values. `parameters` valid.
void PriorVarianceGradient(const CovarianceParameters& parameters, const double* x, double* out);

}  // namespace egosieve::kernels
