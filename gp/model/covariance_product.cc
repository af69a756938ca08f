#include "gp/model/covariance_product.h"

#include <algorithm>
#include <vector>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kProductGroup = 128;  // rows of a tile on a thread at a time

// Adds the parts of (KP1) that belong to a tile whose first element is (row, column): its own, and
// below the diagonal those of its transpose. partial: room for k x columns of each group of rows.
void AddTile(ConstMatrixView<double> tile, int64_t row, int64_t column, ConstMatrixView<double> v,
             std::vector<double>& partial, MatrixView<double> out) {
  const int64_t k = v.rows, groups = (tile.rows + kProductGroup - 1) / kProductGroup;
  const bool both = row != column;
  const int64_t room = k * tile.cols;
  partial.assign(both ? groups * room : 0, 0.0);
  kernels::ParallelFor(groups, 4.0 * k * tile.rows * tile.cols, [&](int64_t g) {
    const int64_t end = std::min(tile.rows, (g + 1) * kProductGroup);
    for (int64_t i = g * kProductGroup; i < end; ++i) {
      const double* values = tile.row(i);
      for (int64_t c = 0; c < k; ++c) {
        out(c, row + i) += LaneDot(values, v.row(c) + column, tile.cols);
        if (!both) continue;
        double* target = partial.data() + g * room + c * tile.cols;
        const double weight = v(c, row + i);
        for (int64_t j = 0; j < tile.cols; ++j) target[j] += weight * values[j];
      }
    }
  });
  for (int64_t g = 0; both && g < groups; ++g) {
    for (int64_t c = 0; c < k; ++c) {
      const double* from = partial.data() + g * room + c * tile.cols;
      for (int64_t j = 0; j < tile.cols; ++j) out(c, column + j) += from[j];
    }
  }
}

}  // namespace

absl::Status MultiplyCovariance(kernels::Context& context,
                                const kernels::CovarianceParameters& covariance,
                                ConstMatrixView<double> x, absl::Span<const double> diagonal,
                                ConstMatrixView<double> v, MatrixView<double> out) {
  const int64_t n = x.rows;
  for (int64_t c = 0; c < v.rows; ++c) {
    for (int64_t i = 0; i < n; ++i) out(c, i) = diagonal[i] * v(c, i);
  }
  const int64_t side = std::min(kProductTile, n);
  AlignedMatrix room(side, side);
  std::vector<double> partial;
  for (int64_t row = 0; row < n; row += kProductTile) {
    const int64_t row_end = std::min(row + kProductTile, n);
    for (int64_t column = 0; column <= row; column += kProductTile) {
      const int64_t column_end = std::min(column + kProductTile, n);
      const MatrixView<double> tile = room.block(row_end - row, column_end - column);
      EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance(context, covariance,
                                                        x.rows_between(row, row_end),
                                                        x.rows_between(column, column_end), tile));
      AddTile(tile, row, column, v, partial, out);
    }
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
