// The tiles of a symmetric matrix's lower triangle, those of its diagonal among them, in parallel.
#ifndef EGOSIEVE_GP_LINALG_LOWER_TILES_H_
#define EGOSIEVE_GP_LINALG_LOWER_TILES_H_

#include <algorithm>
#include <cstdint>

#include "kernels/base/parallel_for.h"

namespace egosieve::gp {

// Calls work(row, column, rows, columns), the first element and the size of a tile, for every tile
// of n x n elements cut into squares of `side`; `flops` in all.
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

#endif  // EGOSIEVE_GP_LINALG_LOWER_TILES_H_
