// Covariance matrices of points.
//
//   K_ij = k(x_i, x_j) + noise_variance [i = j]      CovarianceMatrix, n x n
//   C_ij = k(x_i, z_j)                               CrossCovariance, n x m, streamed in tiles
//
// After an error in the arguments, or a device error before the computation began, `out` is
// unchanged; after a device is lost during the computation `out` may be partly written.
//
// In float64; on a device without it they run on the host.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
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

}  // namespace egosieve::kernels
