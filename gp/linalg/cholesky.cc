#include "gp/linalg/cholesky.h"

#include <algorithm>
#include <limits>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/parallel_for.h"

namespace egosieve::gp {
namespace {

using tile::Block;
using tile::ConstView;
using tile::View;

constexpr int64_t kPanel = 128;       // columns of a panel of the factorisation
constexpr int64_t kRows = 128;        // rows of a tile below the panel
constexpr int64_t kSolvePanel = 256;  // rows solved before the rows below are updated
constexpr int64_t kSolveColumns = 32;
constexpr int64_t kSolveRows = 128;
constexpr int64_t kInverseColumns = 128;  // of L^-1 at a time
constexpr int64_t kProductTile = 256;

int64_t Tiles(int64_t n, int64_t size) { return (n + size - 1) / size; }

void ZeroUpper(View a) {
  for (int64_t i = 0; i < a.rows; ++i) std::fill(a.row(i) + i + 1, a.row(i) + a.cols, 0.0);
}

// X (m x c) := L^-1 X, in blocks of rows, on the calling thread.
void SolveTile(ConstView l, View x) {
  for (int64_t begin = 0; begin < l.rows; begin += kPanel) {
    const int64_t rows = std::min(kPanel, l.rows - begin);
    const View target = Block(x, begin, 0, rows, x.cols);
    tile::SubtractProduct(Block(l, begin, 0, rows, begin), Block(x, 0, 0, begin, x.cols), target);
    tile::SolveLeft(Block(l, begin, begin, rows, rows), target);
  }
}

}  // namespace

std::vector<double> PivotFloors(ConstView a, int64_t order, double factor) {
  std::vector<double> floors(a.rows);
  PivotFloors(a, order, factor, absl::MakeSpan(floors));
  return floors;
}

void PivotFloors(ConstView a, int64_t order, double factor, absl::Span<double> floors) {
  const double relative = factor * static_cast<double>(std::max<int64_t>(order, 1)) *
                          std::numeric_limits<double>::epsilon();
  for (int64_t i = 0; i < a.rows; ++i) floors[i] = std::max(0.0, relative * a(i, i));
}

int64_t FactorizeInParallel(View a, absl::Span<const double> floors) {
  const int64_t n = a.rows;
  for (int64_t begin = 0; begin < n; begin += kPanel) {
    const int64_t columns = std::min(kPanel, n - begin);
    const int64_t below = begin + columns;
    const int64_t tiles = Tiles(n - below, kRows);
    const View corner = Block(a, begin, begin, columns, columns);
    const ConstView panel = Block(a, begin, 0, columns, begin);
    int64_t bad = -1;
    kernels::ParallelFor(tiles + 1, 2.0 * columns * begin * (n - begin), [&](int64_t t) {
      if (t == 0) {
        tile::SubtractProductTransposed(panel, panel, corner);
        bad = tile::Factorize(corner, floors.data() + begin);
        return;
      }
      const int64_t row = below + (t - 1) * kRows;
      const int64_t rows = std::min(kRows, n - row);
      tile::SubtractProductTransposed(Block(a, row, 0, rows, begin), panel,
                                      Block(a, row, begin, rows, columns));
    });
    if (bad >= 0) {
      ZeroUpper(a);
      return begin + bad;
    }
    kernels::ParallelFor(tiles, 1.0 * columns * columns * (n - below), [&](int64_t t) {
      const int64_t row = below + t * kRows;
      tile::SolveRightTransposed(corner, Block(a, row, begin, std::min(kRows, n - row), columns));
    });
  }
  ZeroUpper(a);
  return -1;
}

void SolveLower(ConstView l, View b) {
  const int64_t n = l.rows;
  for (int64_t begin = 0; begin < n; begin += kSolvePanel) {
    const int64_t rows = std::min(kSolvePanel, n - begin);
    const int64_t below = begin + rows;
    kernels::ParallelFor(Tiles(b.cols, kSolveColumns), 1.0 * rows * rows * b.cols, [&](int64_t t) {
      const int64_t column = t * kSolveColumns;
      tile::SolveLeft(Block(l, begin, begin, rows, rows),
                      Block(b, begin, column, rows, std::min(kSolveColumns, b.cols - column)));
    });
    kernels::ParallelFor(
        Tiles(n - below, kSolveRows), 2.0 * rows * (n - below) * b.cols, [&](int64_t t) {
          const int64_t row = below + t * kSolveRows;
          const int64_t count = std::min(kSolveRows, n - row);
          tile::SubtractProduct(Block(l, row, begin, count, rows), Block(b, begin, 0, rows, b.cols),
                                Block(b, row, 0, count, b.cols));
        });
  }
}

void SolveLowerTransposed(ConstView l, View b) {
  const int64_t n = l.rows;
  for (int64_t end = n; end > 0;) {
    const int64_t begin = (end - 1) / kSolvePanel * kSolvePanel;
    const int64_t rows = end - begin;
    kernels::ParallelFor(Tiles(b.cols, kSolveColumns), 1.0 * rows * rows * b.cols, [&](int64_t t) {
      const int64_t column = t * kSolveColumns;
      tile::SolveLeftTransposed(
          Block(l, begin, begin, rows, rows),
          Block(b, begin, column, rows, std::min(kSolveColumns, b.cols - column)));
    });
    kernels::ParallelFor(Tiles(begin, kSolveRows), 2.0 * rows * begin * b.cols, [&](int64_t t) {
      const int64_t row = t * kSolveRows;
      const int64_t count = std::min(kSolveRows, begin - row);
      tile::SubtractTransposedProduct(Block(l, begin, row, rows, count),
                                      Block(b, begin, 0, rows, b.cols),
                                      Block(b, row, 0, count, b.cols));
    });
    end = begin;
  }
}

void AppendRows(ConstView l, View x) {
  const int64_t n = l.rows;
  const int64_t row_tiles = Tiles(x.rows, kSolveRows);
  for (int64_t begin = 0; begin < n; begin += kSolvePanel) {
    const int64_t columns = std::min(kSolvePanel, n - begin);
    const int64_t column_tiles = Tiles(columns, kSolveRows);
    if (begin > 0) {
      kernels::ParallelFor(row_tiles * column_tiles, 2.0 * x.rows * columns * begin,
                           [&](int64_t t) {
                             const int64_t row = t % row_tiles * kSolveRows;
                             const int64_t column = begin + t / row_tiles * kSolveRows;
                             const int64_t rows = std::min(kSolveRows, x.rows - row);
                             const int64_t width = std::min(kSolveRows, begin + columns - column);
                             tile::SubtractProductTransposed(Block(x, row, 0, rows, begin),
                                                             Block(l, column, 0, width, begin),
                                                             Block(x, row, column, rows, width));
                           });
    }
    kernels::ParallelFor(row_tiles, 1.0 * x.rows * columns * columns, [&](int64_t t) {
      const int64_t row = t * kSolveRows;
      tile::SolveRightTransposed(Block(l, begin, begin, columns, columns),
                                 Block(x, row, begin, std::min(kSolveRows, x.rows - row), columns));
    });
  }
}

void InvertLower(ConstView l, View r) {
  const int64_t n = l.rows;
  kernels::ParallelFor(Tiles(n, kInverseColumns), 1.0 * n * n * n / 3.0, [&](int64_t t) {
    const int64_t begin = t * kInverseColumns;
    const int64_t columns = std::min(kInverseColumns, n - begin);
    for (int64_t i = 0; i < n; ++i) {
      std::fill(r.row(i) + begin, r.row(i) + begin + columns, 0.0);
      if (i >= begin && i < begin + columns) r(i, i) = 1.0;
    }
    SolveTile(Block(l, begin, begin, n - begin, n - begin),
              Block(r, begin, begin, n - begin, columns));
  });
}

void MultiplyInverse(ConstView r, View out) {
  const int64_t n = r.rows;
  const auto multiply = [&](int64_t row, int64_t column, int64_t rows, int64_t columns) {
    const View target = Block(out, row, column, rows, columns);
    for (int64_t p = 0; p < rows; ++p) std::fill(target.row(p), target.row(p) + columns, 0.0);
    tile::AddTransposedProduct(Block(r, row, row, n - row, rows),
                               Block(r, row, column, n - row, columns), target);
  };
  ForEachLowerTile(n, kProductTile, 1.0 * n * n * n / 3.0, multiply);
}

void AddRowProducts(ConstView x, int sign, View c) {
  const auto add = [&](int64_t row, int64_t column, int64_t rows, int64_t columns) {
    const ConstView left = Block(x, row, 0, rows, x.cols);
    const ConstView right = Block(x, column, 0, columns, x.cols);
    const View target = Block(c, row, column, rows, columns);
    if (sign > 0) {
      tile::AddProductTransposed(left, right, target);
    } else {
      tile::SubtractProductTransposed(left, right, target);
    }
  };
  ForEachLowerTile(x.rows, kRows, 1.0 * x.rows * x.rows * x.cols, add);
}

void MirrorLower(View c) {
  const auto mirror = [&](int64_t row, int64_t column, int64_t rows, int64_t columns) {
    for (int64_t j = column; j < column + columns; ++j) {
      for (int64_t i = std::max(row, j + 1); i < row + rows; ++i) c(j, i) = c(i, j);
    }
  };
  ForEachLowerTile(c.rows, kRows, 1.0 * c.rows * c.rows, mirror);
}

void InverseColumnNorms(ConstView l, absl::Span<const int64_t> rows, absl::Span<double> out) {
  const int64_t n = l.rows;
  const int64_t count = static_cast<int64_t>(rows.size());
  kernels::ParallelFor(Tiles(count, kInverseColumns), 1.0 * n * n * count / 3.0, [&](int64_t t) {
    const int64_t first = t * kInverseColumns;
    const int64_t columns = std::min(kInverseColumns, count - first);
    const int64_t begin = rows[first];
    const ConstView lower = Block(l, begin, begin, n - begin, n - begin);
    AlignedMatrix buffer(lower.rows, columns);
    const View x = buffer.view();
    for (int64_t i = 0; i < x.rows; ++i) std::fill(x.row(i), x.row(i) + columns, 0.0);
    for (int64_t c = 0; c < columns; ++c) x(rows[first + c] - begin, c) = 1.0;
    SolveTile(lower, x);
    double* norms = out.data() + first;
    std::fill(norms, norms + columns, 0.0);
    for (int64_t i = 0; i < x.rows; ++i) {
      const double* values = x.row(i);
      for (int64_t c = 0; c < columns; ++c) norms[c] += values[c] * values[c];
    }
  });
}

}  // namespace egosieve::gp
