#include "gp/linalg/normal_samples.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kTile = 128;

// z, M x (k S), followed by columns of zeros up to whole tiles.
AlignedMatrix NormalValues(int64_t size, int64_t columns, int64_t count, uint64_t seed) {
  const int64_t width = columns * count;
  AlignedMatrix z(size, (width + kTile - 1) / kTile * kTile);
  for (int64_t i = 0; i < size; ++i) std::fill(z.row(i) + width, z.row(i) + z.cols(), 0.0);
  const uint64_t key = kernels::SplitMix(seed + kernels::kSplitMixStep);
  const int64_t pairs = (size + 1) / 2;
  kernels::ParallelFor(count, 50.0 * size * columns * count, [&](int64_t s) {
    for (int64_t c = 0; c < columns; ++c) {
      const int64_t column = c * count + s;
      const uint64_t first_pair = static_cast<uint64_t>((s * columns + c) * pairs);
      for (int64_t p = 0; p < pairs; ++p) {
        double first, second;
        NormalPair(key, first_pair + p, first, second);
        z.row(2 * p)[column] = first;
        if (2 * p + 1 < size) z.row(2 * p + 1)[column] = second;
      }
    }
  });
  return z;
}

// C in `factor`; returns the jitter.
absl::StatusOr<double> Factorize(ConstMatrixView<double> covariance,
                                 absl::Span<const double> prior_variances,
                                 MatrixView<double> factor) {
  const int64_t size = covariance.rows;
  std::vector<double> floors(prior_variances.begin(), prior_variances.end());
  const double unit = size == 0 ? 0.0 : *std::max_element(floors.begin(), floors.end());
  for (double& floor : floors) floor *= size * std::numeric_limits<double>::epsilon();
  std::optional<double> jitter = 0.0;
  while (jitter.has_value()) {
    for (int64_t i = 0; i < size; ++i) {
      std::copy_n(covariance.row(i), i + 1, factor.row(i));
      factor(i, i) += *jitter;
    }
    if (FactorizeInParallel(factor, floors) < 0) return *jitter;
    jitter = NextJitter(*jitter, unit);
  }
  return absl::FailedPreconditionError(absl::StrFormat(
      "the covariance of %d places is not positive definite; jitter up to %g did not help", size,
      kLastJitter * unit));
}

}  // namespace

absl::StatusOr<NormalSamples> SampleNormal(ConstMatrixView<double> mean,
                                           ConstMatrixView<double> covariance,
                                           absl::Span<const double> prior_variances, int64_t count,
                                           uint64_t seed) {
  if (mean.empty() || count == 0) return NormalSamples{AlignedMatrix(mean.rows, 0), 0.0};
  const int64_t size = mean.rows, width = mean.cols * count;
  AlignedMatrix factor(size, size);
  NormalSamples samples;
  EGOSIEVE_ASSIGN_OR_RETURN(samples.jitter, Factorize(covariance, prior_variances, factor.view()));
  const AlignedMatrix z = NormalValues(size, mean.cols, count, seed);
  samples.values = AlignedMatrix(size, width);
  const int64_t row_tiles = (size + kTile - 1) / kTile, column_tiles = (width + kTile - 1) / kTile;
  const ConstMatrixView<double> c = factor.view();
  kernels::ParallelFor(row_tiles * column_tiles, 1.0 * size * size * width, [&](int64_t t) {
    const int64_t row = t / column_tiles * kTile, column = t % column_tiles * kTile;
    const int64_t rows = std::min(kTile, size - row), columns = std::min(kTile, width - column);
    // Always a whole tile, so that a column's rounding does not depend on the number of columns.
    AlignedMatrix deviation(rows, kTile);
    for (int64_t i = 0; i < rows; ++i) std::fill_n(deviation.row(i), kTile, 0.0);
    tile::AddProduct(tile::Block(c, row, 0, rows, row + rows),
                     tile::Block(z.view(), 0, column, row + rows, kTile), deviation.view());
    for (int64_t i = 0; i < rows; ++i) {
      for (int64_t j = 0; j < columns; ++j) {
        samples.values.row(row + i)[column + j] =
            mean(row + i, (column + j) / count) + deviation.row(i)[j];
      }
    }
  });
  return samples;
}

}  // namespace egosieve::gp
