// Visits the tiles of a symmetric matrix's lower triangle, including the diagonal tiles, in
// parallel.
#pragma once

#include <algorithm>
#include <cstdint>

#include "kernels/base/parallel_for.h"

namespace egosieve::gp {

// Calls work(row, column, rows, columns), the first element and the size of a tile, for every tile.
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

}  // namespace egosieve::gp
