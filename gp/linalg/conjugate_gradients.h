// Solves A x_c = b_c, A symmetric and positive definite, by preconditioned conjugate gradients. The
// columns c have steps of their own and share the products with A.
//
//   z = M^-1 r,  p = z + (r.z / previous r.z) p,  a = r.z / p.A p,  x += a p,  r -= a A p     (CG1)
//
// from x_0 with r = b - A x_0 until |r| <= tolerance |b| for every column. The r of (CG1) drifts
// away from b - A x by rounding. So in the end b - A x is computed, and (CG1) starts again from x
// where that is too large. A solution is returned only if this true residual is within the
// tolerance. It is not, and an error tells how far it came, where the iterations are used up or a
// new start has not halved it: A is then too badly conditioned.
//
// |x - A^-1 b| <= |r| / lambda, lambda: A's least eigenvalue.
//
// Cost: a product with A and one with M^-1 per iteration, and two more with A. Memory: four arrays
// of x's shape. The bits of a column do not depend on the others, but the number of new starts may.
//
// References: Hestenes & Stiefel (1952); Golub & Van Loan, 4th ed., 11.5.
#pragma once

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

struct ConjugateGradientOptions {
  double tolerance = 1e-8;    // of |b - A x| / |b|
  int64_t iterations = 1000;  // of (CG1), at most

  // InvalidArgument unless 0 < tolerance < 1 and iterations are positive.
  absl::Status Validate() const;
};

struct ConjugateGradientReport {
  int64_t iterations = 0;
  double residual = 0.0;  // the largest |b - A x| / |b|; 0 where b = 0, and then x = 0
};

// out := A v or M^-1 v, for each row of v; both k x n.
using LinearMap = absl::FunctionRef<absl::Status(kernels::ConstMatrixView<double> v,
                                                 kernels::MatrixView<double> out)>;

// b, x: k x n with packed rows, a row per column c; x: x_0 before, the solution after.
// NotPositiveDefinite (gp/linalg/not_positive_definite.h) if the tolerance is not reached; x is
// then the last iterate.
absl::StatusOr<ConjugateGradientReport> SolveByConjugateGradients(
    LinearMap multiply, LinearMap precondition, const ConjugateGradientOptions& options,
    kernels::ConstMatrixView<double> b, kernels::MatrixView<double> x);

}  // namespace egosieve::gp
