// Covariance matrices and their gradient on an OpenCL device. Arguments are taken as valid.
#ifndef EGOSIEVE_KERNELS_OPS_OPENCL_COVARIANCE_H_
#define EGOSIEVE_KERNELS_OPS_OPENCL_COVARIANCE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// C(i, j) = k(x_i, z_j); with `lower_only` just j <= i.
template <typename T>
absl::Status CovarianceBlock(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z, bool lower_only,
                             MatrixView<T> out);

// As kernels/ops/covariance_gradient.h; needs float64. With `lower_only` z is x and w symmetric,
// its lower triangle read.
absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> z,
                                                       ConstMatrixView<double> w, bool lower_only);

}  // namespace egosieve::kernels::opencl

#endif  // EGOSIEVE_KERNELS_OPS_OPENCL_COVARIANCE_H_
