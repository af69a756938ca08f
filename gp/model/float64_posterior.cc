#include "gp/model/float64_posterior.h"

#include <algorithm>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/covariance/prior_variance.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/matrix_product.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kTile = 768;         // queries at a time
constexpr int64_t kGroup = 48;         // of them on a thread at a time
constexpr int64_t kPanel = 128;        // columns of the factor
constexpr int64_t kSubstitution = 16;  // columns solved by substitution

// X := X L^-T for a factor L, X R^T for R; `room` has X's shape. All products are those of
// matrix_product.h, whose bits do not depend on the number of rows (AppendRows' do).
void ApplyFactor(const SharedFactor& factor, MatrixView<double> x, MatrixView<double> room) {
  const ConstMatrixView<double> l = factor.values;
  for (int64_t begin = 0; begin < l.rows; begin += kPanel) {
    const int64_t width = std::min(kPanel, l.rows - begin);
    const ConstMatrixView<double> left = tile::Block(l, begin, 0, width, begin + width);
    if (factor.kind != kernels::FactorKind::kCholesky) {
      const MatrixView<double> target = tile::Block(room, 0, begin, x.rows, width);
      for (int64_t i = 0; i < x.rows; ++i) std::fill_n(target.row(i), width, 0.0);
      AddProduct(1.0, AsIs(x), Transposed(left), begin + width, target);
      continue;
    }
    const MatrixView<double> panel = tile::Block(x, 0, begin, x.rows, width);
    AddProduct(-1.0, AsIs(x), Transposed(left), begin, panel);
    for (int64_t j = 0; j < width; j += kSubstitution) {
      const int64_t columns = std::min(kSubstitution, width - j);
      const MatrixView<double> target = tile::Block(panel, 0, j, x.rows, columns);
      AddProduct(-1.0, AsIs(panel), Transposed(tile::Block(l, begin + j, begin, columns, j)), j,
                 target);
      tile::SolveRightTransposed(tile::Block(l, begin + j, begin + j, columns, columns), target);
    }
  }
  if (factor.kind == kernels::FactorKind::kCholesky) return;
  for (int64_t i = 0; i < x.rows; ++i) std::copy_n(room.row(i), x.cols, x.row(i));
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
  const bool solves = factor_.kind == kernels::FactorKind::kCholesky;
  int64_t clamped = 0;
  AlignedMatrix cross(std::min(kTile, queries.rows), n);
  std::vector<double> lefts(cross.rows());
  for (int64_t begin = 0; begin < queries.rows; begin += kTile) {
    const ConstMatrixView<double> tile =
        queries.rows_between(begin, std::min(begin + kTile, queries.rows));
    EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance<double>(*context_, covariance, tile, inputs(),
                                                              cross.block(tile.rows, n)));
    const double flops = tile.rows * (2.0 * n * (k + q) + (variances == nullptr ? 0.0 : n * n));
    kernels::ParallelFor((tile.rows + kGroup - 1) / kGroup, flops, [&](int64_t g) {
      const int64_t first = g * kGroup, count = std::min(kGroup, tile.rows - first);
      const MatrixView<double> rows(cross.row(first), count, n, cross.stride());
      absl::FixedArray<double, 64> sums(std::max(k, 2 * q));
      for (int64_t i = 0; i < count; ++i) {
        const double* x = tile.row(first + i);
        if (means != nullptr) {
          WeightedSums(rows.row(i), weights_.alpha, n, k, sums.data());
          weights_.AddMeanFunction(tile.cols, x, sums.data());
          std::copy_n(sums.begin(), k, means + (begin + first + i) * k);
        }
        if (variances == nullptr) continue;
        lefts[first + i] = PriorVariance(covariance, x);
        if (q == 0) continue;
        WeightedSums(rows.row(i), weights_.basis_weights, n, q, sums.data());
        lefts[first + i] += weights_.ReducedBasis(tile.cols, x, sums.data(), sums.data() + q);
      }
      if (variances == nullptr) return;
      AlignedMatrix room(solves ? 0 : count, n);
      ApplyFactor(factor_, rows, room.view());
      for (int64_t i = 0; i < count; ++i) lefts[first + i] -= Square(rows.row(i), n);
    });
    for (int64_t i = 0; variances != nullptr && i < tile.rows; ++i) {
      clamped += lefts[i] < 0.0;
      variances[begin + i] = std::max(0.0, lefts[i]);
    }
  }
  return clamped;
}

}  // namespace egosieve::gp
