#include "gp/model/float64_posterior.h"

#include <algorithm>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/matrix_product.h"
#include "gp/linalg/tile_operations.h"
#include "gp/model/point_set.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/exact_regression.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kFloat64QueryTile = 768;  // queries at a time, at most
constexpr int64_t kFloat64TileValues = int64_t{1} << 25;
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

// The same on several threads, for many rows whose bits may depend on their number.
void ApplyFactorInParallel(const SharedFactor& factor, MatrixView<double> x) {
  if (factor.kind == kernels::FactorKind::kCholesky) return AppendRows(factor.values, x);
  kernels::ParallelFor((x.rows + kGroup - 1) / kGroup, 1.0 * x.rows * x.cols * x.cols,
                       [&](int64_t g) {
                         const int64_t first = g * kGroup;
                         const MatrixView<double> rows =
                             tile::Block(x, first, 0, std::min(kGroup, x.rows - first), x.cols);
                         AlignedMatrix room(rows.rows, rows.cols);
                         ApplyFactor(factor, rows, room.view());
                       });
}

// M^-1 r of (W4), one row per point.
AlignedMatrix ReducedBases(const RegressionWeights& weights, ConstMatrixView<double> points,
                           ConstMatrixView<double> k) {
  AlignedMatrix reduced(points.rows, weights.basis);
  if (weights.basis == 0) return reduced;
  kernels::ParallelFor(points.rows, 2.0 * k.rows * k.cols * weights.basis, [&](int64_t i) {
    absl::FixedArray<double, 64> sums(weights.basis);
    WeightedSums(k.row(i), weights.basis_weights, weights.points, weights.basis, sums.data());
    weights.ReducedBasis(points.cols, points.row(i), sums.data(), reduced.row(i));
  });
  return reduced;
}

void Transpose(ConstMatrixView<double> from, MatrixView<double> to) {
  for (int64_t i = 0; i < from.rows; ++i) {
    for (int64_t j = 0; j < from.cols; ++j) to(j, i) = from(i, j);
  }
}

}  // namespace

absl::Status NeedsFactor() {
  return absl::FailedPreconditionError(
      "an iterative model predicts means alone; variances, samples, probabilities, likelihoods and "
      "left-out points need an exact or a sparse model");
}

Float64Posterior::Float64Posterior(std::shared_ptr<kernels::Context> context,
                                   const Hyperparameters& hyperparameters,
                                   ConstMatrixView<double> inputs, const RegressionWeights& weights,
                                   SharedFactor factor)
    : context_(std::move(context)),
      hyperparameters_(hyperparameters),
      inputs_(Widen(inputs)),
      weights_(weights),
      factor_(std::move(factor)) {}

absl::StatusOr<int64_t> Float64Posterior::Evaluate(ConstMatrixView<double> queries, double* means,
                                                   double* variances) const {
  if (variances != nullptr && !has_factor()) return NeedsFactor();
  EGOSIEVE_RETURN_IF_ERROR(factor_.values.rows > 0 && kernels::RegressesOnDevice(*context_)
                               ? SumOnDevice(queries, means, variances)
                               : SumOnHost(queries, means, variances, /*with_factor=*/true));
  int64_t clamped = 0;
  for (int64_t i = 0; variances != nullptr && i < queries.rows; ++i) {
    clamped += variances[i] < 0.0;
    variances[i] = std::max(0.0, variances[i]);
  }
  return clamped;
}

absl::StatusOr<std::shared_ptr<const kernels::Float64Sums>> Float64Posterior::OnDevice(
    bool with_variance) const {
  const std::lock_guard lock(mutex_);
  if (all_on_device_ != nullptr) return all_on_device_;
  std::shared_ptr<const kernels::Float64Sums>& kept =
      with_variance ? all_on_device_ : means_on_device_;
  if (kept != nullptr) return kept;
  const int64_t n = weights_.points, k = weights_.outputs, q = weights_.basis;
  std::vector<double> weights(n * (k + q));  // alpha, W
  for (int64_t i = 0; i < n; ++i) {
    std::copy_n(&weights_.alpha[i * k], k, &weights[i * (k + q)]);
    if (q > 0) std::copy_n(&weights_.basis_weights[i * q], q, &weights[i * (k + q) + k]);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(
      kept, kernels::Float64Sums::Create(
                context_, hyperparameters_.covariance, inputs(), {weights.data(), n, k + q},
                with_variance ? factor_.kind : kernels::FactorKind::kNone, factor_.values));
  if (with_variance) means_on_device_.reset();
  return kept;
}

absl::Status Float64Posterior::SumOnDevice(ConstMatrixView<double> queries, double* means,
                                           double* variances) const {
  const int64_t k = weights_.outputs, q = weights_.basis;
  EGOSIEVE_ASSIGN_OR_RETURN(const auto on_device, OnDevice(variances != nullptr));
  std::vector<double> sums(queries.rows * (k + q));
  EGOSIEVE_RETURN_IF_ERROR(
      on_device->Evaluate(queries, {sums.data(), queries.rows, k + q}, variances));
  std::vector<double> reduced(q);
  for (int64_t i = 0; i < queries.rows; ++i) {
    const double* x = queries.row(i);
    double* sum = &sums[i * (k + q)];
    if (variances != nullptr) {
      variances[i] = PriorVariance(hyperparameters_.covariance, x) - variances[i];
      if (q > 0) variances[i] += weights_.ReducedBasis(queries.cols, x, sum + k, reduced.data());
    }
    if (means == nullptr) continue;
    weights_.AddMeanFunction(queries.cols, x, sum);
    std::copy_n(sum, k, means + i * k);
  }
  return absl::OkStatus();
}

absl::Status Float64Posterior::SumOnHost(ConstMatrixView<double> queries, double* means,
                                         double* variances, bool with_factor) const {
  const kernels::CovarianceParameters& covariance = hyperparameters_.covariance;
  const int64_t n = factor_.values.rows, k = weights_.outputs, q = weights_.basis;
  const bool solves = factor_.kind == kernels::FactorKind::kCholesky;
  const int64_t side =
      std::clamp(kFloat64TileValues / std::max<int64_t>(n, 1), kGroup, kFloat64QueryTile);
  AlignedMatrix cross(std::min(side, queries.rows), n);
  for (int64_t begin = 0; begin < queries.rows; begin += side) {
    const ConstMatrixView<double> tile =
        queries.rows_between(begin, std::min(begin + side, queries.rows));
    EGOSIEVE_RETURN_IF_ERROR(
        kernels::CrossCovariance(*context_, covariance, tile, inputs(), cross.block(tile.rows, n)));
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
        double& variance = variances[begin + first + i];
        variance = with_factor ? PriorVariance(covariance, x) : 0.0;
        if (q == 0) continue;
        WeightedSums(rows.row(i), weights_.basis_weights, n, q, sums.data());
        variance += weights_.ReducedBasis(tile.cols, x, sums.data(), sums.data() + q);
      }
      if (variances == nullptr || !with_factor) return;
      AlignedMatrix room(solves ? 0 : count, n);
      ApplyFactor(factor_, rows, room.view());
      for (int64_t i = 0; i < count; ++i) {
        variances[begin + first + i] -= Square(rows.row(i), n);
      }
    });
  }
  return absl::OkStatus();
}

absl::StatusOr<JointPrediction> Float64Posterior::PredictJoint(
    ConstMatrixView<double> points) const {
  const kernels::CovarianceParameters& parameters = hyperparameters_.covariance;
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, parameters.input_dimension()));
  if (!has_factor()) return NeedsFactor();
  JointPrediction joint;
  joint.mean.resize(points.rows * weights_.outputs);
  joint.covariance = AlignedMatrix(points.rows, points.rows);
  const MatrixView<double> covariance = joint.covariance.view();
  AlignedMatrix cross(points.rows, factor_.values.rows);
  EGOSIEVE_RETURN_IF_ERROR(
      kernels::CrossCovariance(*context_, parameters, points, inputs(), cross.view()));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(*context_, parameters, points, 0.0,
                                                     kernels::Triangle::kLower, covariance));
  kernels::ParallelFor(
      points.rows, 2.0 * cross.rows() * cross.cols() * weights_.outputs, [&](int64_t i) {
        double* mean = &joint.mean[i * weights_.outputs];
        WeightedSums(cross.row(i), weights_.alpha, cross.cols(), weights_.outputs, mean);
        weights_.AddMeanFunction(points.cols, points.row(i), mean);
      });
  const AlignedMatrix reduced = ReducedBases(weights_, points, cross.view());
  ApplyFactorInParallel(factor_, cross.view());
  AddRowProducts(cross.view(), -1, covariance);  // (FP1)
  AddRowProducts(reduced.view(), 1, covariance);
  for (int64_t i = 0; i < points.rows; ++i) covariance(i, i) = std::max(0.0, covariance(i, i));
  MirrorLower(covariance);
  return joint;
}

absl::StatusOr<NormalSamples> Float64Posterior::Sample(ConstMatrixView<double> points,
                                                       const SampleOptions& options) const {
  EGOSIEVE_ASSIGN_OR_RETURN(JointPrediction joint, PredictJoint(points));
  std::vector<double> prior(points.rows);
  for (int64_t i = 0; i < points.rows; ++i) {
    prior[i] = PriorVariance(hyperparameters_.covariance, points.row(i));
    if (options.of_observation) joint.covariance.row(i)[i] += hyperparameters_.noise_variance();
  }
  return SampleNormal({joint.mean.data(), points.rows, weights_.outputs}, joint.covariance.view(),
                      prior, options.count, options.seed);
}

absl::StatusOr<InputGradients> Float64Posterior::PredictGradients(ConstMatrixView<double> points,
                                                                  PredictWhat what) const {
  const int64_t dimension = hyperparameters_.covariance.input_dimension();
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(points, dimension));
  const int64_t k = weights_.outputs, n = factor_.values.rows;
  InputGradients gradients;
  if (points.rows == 0) return gradients;
  gradients.mean.resize(points.rows * k * dimension);
  for (int64_t c = 0; c < k; ++c) {  // (FP2)
    std::vector<double> alpha(n);
    for (int64_t i = 0; i < n; ++i) alpha[i] = weights_.alpha[i * k + c];
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceInputGradient(
        hyperparameters_.covariance, points, inputs(), {alpha.data(), points.rows, n, 0},
        {&gradients.mean[c * dimension], points.rows, dimension, k * dimension}));
    if (weights_.mean != MeanFunction::kLinear) continue;
    for (int64_t i = 0; i < points.rows; ++i) {
      for (int64_t d = 0; d < dimension; ++d) {
        gradients.mean[(i * k + c) * dimension + d] += weights_.coefficients[(d + 1) * k + c];
      }
    }
  }
  if (what == PredictWhat::kMean) return gradients;
  if (!has_factor()) return NeedsFactor();
  gradients.variance.resize(points.rows * dimension);
  for (int64_t begin = 0; begin < points.rows; begin += kFloat64QueryTile) {
    const int64_t end = std::min(begin + kFloat64QueryTile, points.rows);
    EGOSIEVE_RETURN_IF_ERROR(
        VarianceGradients(points.rows_between(begin, end),
                          {&gradients.variance[begin * dimension], end - begin, dimension}));
  }
  return gradients;
}

absl::Status Float64Posterior::VarianceGradients(ConstMatrixView<double> points,
                                                 MatrixView<double> out) const {
  const int64_t n = factor_.values.rows, q = weights_.basis;
  AlignedMatrix columns(n, points.rows), rows(points.rows, n), u(points.rows, q);
  EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance(*context_, hyperparameters_.covariance,
                                                    inputs(), points, columns.view()));
  Transpose(columns.view(), rows.view());
  for (int64_t i = 0; q > 0 && i < points.rows; ++i) {
    absl::FixedArray<double, 64> sums(q);
    WeightedSums(rows.row(i), weights_.basis_weights, n, q, sums.data());
    weights_.ReducedBasis(points.cols, points.row(i), sums.data(), u.row(i));
    SolveLowerTransposed({weights_.information.data(), q, q}, MatrixView<double>(u.row(i), q, 1));
  }
  if (factor_.kind == kernels::FactorKind::kCholesky) {
    SolveLower(factor_.values, columns.view());
    SolveLowerTransposed(factor_.values, columns.view());
    Transpose(columns.view(), rows.view());  // K_y^-1 k*, one row per point
  } else {
    ApplyFactorInParallel(factor_, rows.view());
    AlignedMatrix product(points.rows, n);
    for (int64_t i = 0; i < points.rows; ++i) std::fill_n(product.row(i), n, 0.0);
    AddProduct(1.0, AsIs(rows.view()), AsIs(factor_.values), n, product.view());
    rows = std::move(product);
  }
  for (int64_t i = 0; i < points.rows; ++i) {
    for (int64_t j = 0; j < n; ++j) {
      for (int64_t p = 0; p < q; ++p) {
        rows.row(i)[j] += weights_.basis_weights[j * q + p] * u.row(i)[p];
      }
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceInputGradient(hyperparameters_.covariance, points,
                                                            inputs(), rows.view(), out));
  std::vector<double> prior(points.cols);
  for (int64_t i = 0; i < points.rows; ++i) {  // (FP3)
    kernels::PriorVarianceGradient(hyperparameters_.covariance, points.row(i), prior.data());
    for (int64_t d = 0; d < points.cols; ++d) {
      out(i, d) = prior[d] - 2.0 * out(i, d);
      if (weights_.mean == MeanFunction::kLinear) out(i, d) += 2.0 * u.row(i)[d + 1];
    }
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
