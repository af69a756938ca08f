// Dense operations on tiles, each on one thread: the building blocks of this folder's parallel
// algorithms. All matrices are row-major views; tiles may lie inside larger matrices.
//
// Triangular solves and the factorisation halve the matrix recursively, so that nearly all of the
// work is matrix multiplication. The smallest blocks are solved by substitution, never by explicit
// inverses, so that the backward error is that of substitution.
#pragma once

#include <cstdint>

#include "kernels/base/matrix_view.h"

namespace egosieve::gp::tile {

using View = kernels::MatrixView<double>;
using ConstView = kernels::ConstMatrixView<double>;

// The rows x cols block of `m` whose first element is (row, col).
template <typename T>
kernels::MatrixView<T> Block(const kernels::MatrixView<T>& m, int64_t row, int64_t col,
                             int64_t rows, int64_t cols) {
  return {m.data + row * m.stride + col, rows, cols, m.stride};
}

void SubtractProduct(ConstView a, ConstView b, View c);            // C -= A B
void SubtractProductTransposed(ConstView a, ConstView b, View c);  // C -= A B^T
void SubtractTransposedProduct(ConstView a, ConstView b, View c);  // C -= A^T B
void AddProduct(ConstView a, ConstView b, View c);                 // C += A B
void AddProductTransposed(ConstView a, ConstView b, View c);       // C += A B^T
void AddTransposedProduct(ConstView a, ConstView b, View c);       // C += A^T B

// L is lower triangular with a non-zero diagonal; elements above it are not read.
void SolveLeft(ConstView l, View b);             // B := L^-1 B
void SolveLeftTransposed(ConstView l, View b);   // B := L^-T B
void SolveRightTransposed(ConstView l, View x);  // X := X L^-T

// The lower triangle of A becomes its Cholesky factor; elements above the diagonal are not read but
// may be overwritten. Returns -1, or the first row i whose pivot is not above floors[i]; then A is
// partly overwritten.
int64_t Factorize(View a, const double* floors);

}  // namespace egosieve::gp::tile
