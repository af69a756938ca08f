// Products of a covariance matrix that is never stored:
//
//   out_c = (K + diag(d)) v_c,   K_ij = k(x_i, x_j)                                          (KP1)
//
// Tiles of K's lower triangle, kProductTile rows and columns each, are computed one after another
// by kernels/ops/covariance_matrix.h in float64 and used twice, as K is symmetric.
//
// Cost: n^2 / 2 covariances and 2 k n^2 multiply-adds for k rows of v. Memory: 8 MiB for the tile,
// and kProductTile k values for each group of its rows. The bits do not depend on the number of
// threads.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// Of 512, 1024 and 2048 the one with the least time of processors: 5.4, 4.9 and 5.8 s by
// bench/peers/many_points.py --methods=product --points=12000 --dimensions=2, on two cores.
inline constexpr int64_t kProductTile = 1024;

// x: n x D, finite; diagonal: n; v, out: k x n.
absl::Status MultiplyCovariance(kernels::Context& context,
                                const kernels::CovarianceParameters& covariance,
                                kernels::ConstMatrixView<double> x,
                                absl::Span<const double> diagonal,
                                kernels::ConstMatrixView<double> v,
                                kernels::MatrixView<double> out);

}  // namespace egosieve::gp
