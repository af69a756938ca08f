#include "kernels/reference/dense_posterior.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "kernels/reference/covariance.h"

namespace egosieve::kernels::reference {
namespace {

// Queries per tile. Tiles are always full (the last one is padded with zeros), so that every column
// takes the same path through Eigen's products, and a query's result does not depend on the other
// queries.
constexpr int64_t kTile = 64;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

double NormalCdf(double x) { return 0.5 * std::erfc(-x * 0.70710678118654752440); }

DensePosterior::DensePosterior(const PosteriorModel& model)
    : covariance_(model.covariance),
      count_(model.inputs.rows),
      alpha_(model.alpha, model.alpha + count_),
      factor_kind_(model.factor_kind),
      squash_a_(model.squash_a),
      squash_b_(model.squash_b) {
  for (int64_t i = 0; i < count_; ++i) {
    inputs_.insert(inputs_.end(), model.inputs.row(i), model.inputs.row(i) + model.inputs.cols);
  }
  if (factor_kind_ != FactorKind::kNone) {
    factor_.assign(count_ * count_, 0.0);
    for (int64_t i = 0; i < count_; ++i) {
      std::copy_n(model.factor.row(i), i + 1, &factor_[i * count_]);
    }
  }
}

void DensePosterior::ApplyFactor(std::vector<double>& columns) const {
  const Eigen::Map<const RowMajor> factor(factor_.data(), count_, count_);
  Eigen::Map<Eigen::MatrixXd> k(columns.data(), count_, kTile);
  if (factor_kind_ == FactorKind::kCholesky) {
    factor.triangularView<Eigen::Lower>().solveInPlace(k);
  } else {
    const Eigen::MatrixXd product = factor.triangularView<Eigen::Lower>() * k;
    k = product;
  }
}

template <typename Query, typename Real>
int64_t DensePosterior::Evaluate(ConstMatrixView<Query> queries, Real* mean, Real* variance,
                                 Real* probability) const {
  const int64_t dimension = covariance_.input_dimension();
  const ConstMatrixView<double> inputs(inputs_.data(), count_, dimension);
  const bool needs_variance = (variance != nullptr || probability != nullptr);
  int64_t clamped = 0;
  std::vector<double> points(kTile * dimension);
  std::vector<double> columns(count_ * kTile);
  for (int64_t begin = 0; begin < queries.rows; begin += kTile) {
    const int64_t size = std::min(kTile, queries.rows - begin);
    std::fill(points.begin(), points.end(), 0.0);
    std::fill(columns.begin(), columns.end(), 0.0);
    for (int64_t q = 0; q < size; ++q) {
      std::copy_n(queries.row(begin + q), dimension, &points[q * dimension]);
    }
    CovarianceBlock(covariance_, ConstMatrixView<double>(points.data(), size, dimension), inputs,
                    false, MatrixView<double>(columns.data(), size, count_));
    double means[kTile];
    for (int64_t q = 0; q < size; ++q) {
      means[q] = 0.0;
      for (int64_t i = 0; i < count_; ++i) {
        means[q] += columns[q * count_ + i] * alpha_[i];
      }
      if (mean != nullptr) mean[begin + q] = static_cast<Real>(means[q]);
    }
    if (!needs_variance) continue;
    if (count_ > 0 && factor_kind_ != FactorKind::kNone) ApplyFactor(columns);
    for (int64_t q = 0; q < size; ++q) {
      const double* x = &points[q * dimension];
      double value = Covariance(covariance_, x, x);
      for (int64_t i = 0; i < count_; ++i) {
        value -= columns[q * count_ + i] * columns[q * count_ + i];
      }
      if (value < 0.0) {
        value = 0.0;
        ++clamped;
      }
      if (variance != nullptr) variance[begin + q] = static_cast<Real>(value);
      if (probability != nullptr) {
        probability[begin + q] = static_cast<Real>(NormalCdf(
            (squash_a_ * means[q] + squash_b_) / std::sqrt(1.0 + squash_a_ * squash_a_ * value)));
      }
    }
  }
  return clamped;
}

template int64_t DensePosterior::Evaluate(ConstMatrixView<float>, float*, float*, float*) const;
template int64_t DensePosterior::Evaluate(ConstMatrixView<float>, double*, double*, double*) const;
template int64_t DensePosterior::Evaluate(ConstMatrixView<double>, float*, float*, float*) const;
template int64_t DensePosterior::Evaluate(ConstMatrixView<double>, double*, double*, double*) const;

}  // namespace egosieve::kernels::reference
