// The data of a Gaussian process posterior; the formulas are in kernels/ops/dense_posterior.h.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels {

enum class FactorKind {
  kNone,             // means only
  kCholesky,         // L, lower: variance = k** - |L^-1 k*|^2
  kInverseCholesky,  // R, lower: variance = k** - |R k*|^2; R = L^-1, or the factor of
                     // K_mm^-1 - Sigma^-1 = R^T R of a sparse model
};

struct PosteriorModel {
  CovarianceParameters covariance;
  ConstMatrixView<double> inputs;  // n x D; n = 0 gives the prior
  const double* alpha = nullptr;   // n
  FactorKind factor_kind = FactorKind::kNone;
  ConstMatrixView<double> factor;  // n x n, lower triangle read
  double squash_a = 1.0;
  double squash_b = 0.0;

  // InvalidArgument, naming field and value, for inconsistent shapes, NaN or infinite values, or a
  // Cholesky factor with a diagonal element that is not positive.
  absl::Status Validate() const;
};

}  // namespace egosieve::kernels
