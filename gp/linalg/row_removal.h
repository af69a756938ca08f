// Removes rows and columns from a factored matrix, (IC1)-(IC3) of gp/linalg/incremental_cholesky.h.
//
// The removed rows of L are set aside and the others moved together. The rows below the first
// removed one then hold [C1, C2]: C1 lower triangular (the remaining columns of L), C2 with one
// column per removed row. Householder reflectors from the right eliminate C2 row by row,
//
//   norm = |(l, c)|,  v0 = l - norm = -c.c / (l + norm),  v = c / v0,
//   tau = 2 v0^2 / (c.c + v0^2),   l' = norm                                              (1)
//
// where l is C1's diagonal element and c its row of C2; l' > 0, so that no sign needs correction.
// The reflectors of a panel of columns act together on rows below as I - [I; V^T] T [I; V^T]^T,
//
//   W = C1 + C2 V^T,  C1 -= W T,  C2 -= W T V                                             (2)
//
// Rows are processed in blocks. Each block applies all panels to its left once (left-looking): L is
// read and written once. Blocks are tasks that wait for the panels they need. All memory is
// allocated before the first row is moved.
#pragma once

#include <cstdint>

#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// l: n x n, lower triangular with zeros above the diagonal; rows: indices in [0, n), strictly
// increasing. Afterwards the leading block of size n - rows.size() is the factor of the remaining
// matrix, with zeros above the diagonal; the last rows are undefined on and below their diagonal.
// std::bad_alloc leaves l as it was.
void RemoveRows(kernels::MatrixView<double> l, absl::Span<const int64_t> rows);

}  // namespace egosieve::gp
