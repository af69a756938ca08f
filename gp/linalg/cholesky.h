// Cholesky factorisation, triangular solves and triangular inverses of large matrices in float64.
// Threads (kernels/base/parallel_for.h) share the work in fixed tiles, so that the bits are the
// same for any thread count. All matrices are row-major views.
//
//   function             result                       cost (flops)
//   FactorizeInParallel  L, A = L L^T                 n^3 / 3
//   SolveLower           L^-1 B, c columns            c n^2
//   SolveLowerTransposed L^-T B                       c n^2
//   AppendRows           X L^-T, k rows               k n^2
//   InvertLower          R = L^-1                     n^3 / 3
//   MultiplyInverse      R^T R = (L L^T)^-1           n^3 / 3
//   InverseColumnNorms   |L^-1 e_r|^2                 sum over r of (n - r)^2
//   AddRowProducts       C + sign X X^T, k rows       k^2 n
//
// The first is left-looking: panel p of columns is  A_p - L_<p L_p,<p^T, then L_pp and the rows
// below it (Golub & Van Loan, 4th ed., 4.2.5-4.2.7).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/parallel_for.h"

namespace egosieve::gp {

// Pivot floors for the `Factorize` functions: factor * max(n, 1) * eps * diagonal_i.
std::vector<double> PivotFloors(kernels::ConstMatrixView<double> a, int64_t order, double factor);
// The same into `floors`, of A's rows.
void PivotFloors(kernels::ConstMatrixView<double> a, int64_t order, double factor,
                 absl::Span<double> floors);

// The lower triangle of A becomes L, the strict upper one zero. Returns -1, or the first row i
// whose pivot (square of L(i,i)) is not above floors[i] or not finite; then the lower triangle is
// partly overwritten.
int64_t FactorizeInParallel(kernels::MatrixView<double> a, absl::Span<const double> floors);

// B := L^-1 B and B := L^-T B. L's strict upper triangle is not read.
void SolveLower(kernels::ConstMatrixView<double> l, kernels::MatrixView<double> b);
void SolveLowerTransposed(kernels::ConstMatrixView<double> l, kernels::MatrixView<double> b);

// X := X L^-T; X: k x n.
void AppendRows(kernels::ConstMatrixView<double> l, kernels::MatrixView<double> x);

// r := L^-1, with zeros above the diagonal.
void InvertLower(kernels::ConstMatrixView<double> l, kernels::MatrixView<double> r);

// The lower triangle of `out` := that of R^T R, R lower triangular; the strict upper triangle of
// `out` may be overwritten.
void MultiplyInverse(kernels::ConstMatrixView<double> r, kernels::MatrixView<double> out);

// out_s = |L^-1 e_r|^2 for r = rows[s], increasing.
void InverseColumnNorms(kernels::ConstMatrixView<double> l, absl::Span<const int64_t> rows,
                        absl::Span<double> out);

// The lower triangle of C := that of C + sign X X^T, X: k x n, C: k x k, sign 1 or -1; the strict
// upper triangle may be overwritten.
void AddRowProducts(kernels::ConstMatrixView<double> x, int sign, kernels::MatrixView<double> c);

// a.b and |a|^2 of n values, summed in order.
inline double Dot(const double* a, const double* b, int64_t n) {
  double sum = 0.0;
  for (int64_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}
inline double Square(const double* a, int64_t n) { return Dot(a, a, n); }

// a.b of n values, summed in eight lanes, so that it vectorises, in an order of its own.
inline double LaneDot(const double* a, const double* b, int64_t n) {
  double lanes[8] = {};
  int64_t i = 0;
  for (; i + 8 <= n; i += 8) {
    for (int lane = 0; lane < 8; ++lane) lanes[lane] += a[i + lane] * b[i + lane];
  }
  double sum = ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) +
               ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
  for (; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

// Visits the tiles of a symmetric matrix's lower triangle, including the diagonal tiles, in parallel:
// calls work(row, column, rows, columns), the first element and the size of a tile, for every tile.
// The n x n matrix is cut into squares of `side`. flops: for all tiles together.
template <typename Work>
void ForEachLowerTile(int64_t n, int64_t side, double flops, const Work& work) {
  const int64_t tiles = (n + side - 1) / side;
  kernels::ParallelFor(tiles * (tiles + 1) / 2, flops, [&](int64_t t) {
    int64_t i = 0;
    while ((i + 1) * (i + 2) / 2 <= t) ++i;
    const int64_t row = i * side, column = (t - i * (i + 1) / 2) * side;
    work(row, column, std::min(side, n - row), std::min(side, n - column));
  });
}

// Copies the lower triangle, mirrored, into the upper one.
void MirrorLower(kernels::MatrixView<double> c);

}  // namespace egosieve::gp
