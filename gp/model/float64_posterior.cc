#include "gp/model/float64_posterior.h"

#include <algorithm>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kTile = 512;         // queries at a time
constexpr int64_t kProductTile = 128;  // rows and columns of a product

// K R^T, R lower triangular.
AlignedMatrix ProductWithTransposed(ConstMatrixView<double> k, ConstMatrixView<double> r) {
  AlignedMatrix product(k.rows, r.rows);
  const int64_t down = (k.rows + kProductTile - 1) / kProductTile;
  const int64_t across = (r.rows + kProductTile - 1) / kProductTile;
  kernels::ParallelFor(down * across, 1.0 * k.rows * r.rows * r.rows, [&](int64_t t) {
    const int64_t row = t % down * kProductTile, column = t / down * kProductTile;
    const int64_t rows = std::min(kProductTile, k.rows - row);
    const int64_t columns = std::min(kProductTile, r.rows - column);
    const MatrixView<double> target = tile::Block(product.view(), row, column, rows, columns);
    for (int64_t i = 0; i < rows; ++i) std::fill_n(target.row(i), columns, 0.0);
    tile::AddProductTransposed(tile::Block(k, row, 0, rows, column + columns),
                               tile::Block(r, column, 0, columns, column + columns), target);
  });
  return product;
}

}  // namespace

Float64Posterior::Float64Posterior(std::shared_ptr<kernels::Context> context,
                                   const Hyperparameters& hyperparameters,
                                   ConstMatrixView<double> inputs, const RegressionWeights& weights,
                                   SharedFactor factor)
    : context_(std::move(context)),
      hyperparameters_(hyperparameters),
      weights_(weights),
      factor_(std::move(factor)) {
  for (int64_t i = 0; i < inputs.rows; ++i) {
    inputs_.insert(inputs_.end(), inputs.row(i), inputs.row(i) + inputs.cols);
  }
}

absl::StatusOr<int64_t> Float64Posterior::Evaluate(ConstMatrixView<double> queries, double* means,
                                                   double* variances) const {
  const kernels::CovarianceParameters& covariance = hyperparameters_.covariance;
  const int64_t n = factor_.values.rows, k = weights_.outputs, q = weights_.basis;
  int64_t clamped = 0;
  AlignedMatrix cross(std::min(kTile, queries.rows), n);
  for (int64_t begin = 0; begin < queries.rows; begin += kTile) {
    const ConstMatrixView<double> tile =
        queries.rows_between(begin, std::min(begin + kTile, queries.rows));
    const MatrixView<double> rows = cross.block(tile.rows, n);
    EGOSIEVE_RETURN_IF_ERROR(
        kernels::CrossCovariance<double>(*context_, covariance, tile, inputs(), rows));
    std::vector<double> added(variances == nullptr ? 0 : tile.rows);  // |M^-1 r|^2
    kernels::ParallelFor(tile.rows, 2.0 * tile.rows * n * (k + q), [&](int64_t i) {
      absl::FixedArray<double, 64> sums(std::max(k, 2 * q));
      if (means != nullptr) {
        WeightedSums(rows.row(i), weights_.alpha, n, k, sums.data());
        weights_.AddMeanFunction(tile.cols, tile.row(i), sums.data());
        std::copy_n(sums.begin(), k, means + (begin + i) * k);
      }
      if (variances != nullptr && q > 0) {
        WeightedSums(rows.row(i), weights_.basis_weights, n, q, sums.data());
        added[i] = weights_.ReducedBasis(tile.cols, tile.row(i), sums.data(), sums.data() + q);
      }
    });
    if (variances == nullptr) continue;
    const bool substitutes = factor_.kind == kernels::FactorKind::kCholesky;
    if (substitutes) AppendRows(factor_.values, rows);
    const AlignedMatrix product =
        substitutes ? AlignedMatrix() : ProductWithTransposed(rows, factor_.values);
    for (int64_t i = 0; i < tile.rows; ++i) {
      const double explained = Square(substitutes ? rows.row(i) : product.row(i), n);
      const double left = PriorVariance(covariance, tile.row(i)) - explained + added[i];
      clamped += left < 0.0;
      variances[begin + i] = std::max(0.0, left);
    }
  }
  return clamped;
}

}  // namespace egosieve::gp
