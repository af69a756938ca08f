// Seeded matrices for the laws of the linear algebra's tests.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "gp/linalg/incremental_cholesky.h"
#include "gtest/gtest.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

using NarrowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline kernels::MatrixView<double> ViewOf(RowMatrix& m) { return {m.data(), m.rows(), m.cols()}; }
inline kernels::ConstMatrixView<double> ViewOf(const RowMatrix& m) {
  return {m.data(), m.rows(), m.cols()};
}
inline RowMatrix CopyOf(kernels::ConstMatrixView<double> view) {
  RowMatrix out(view.rows, view.cols);
  for (int64_t i = 0; i < view.rows; ++i) std::copy_n(view.row(i), view.cols, out.row(i).data());
  return out;
}

// Seeded by the running test's name.
inline std::mt19937_64 TestGenerator() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  return std::mt19937_64(
      std::hash<std::string>()(std::string(info->test_suite_name()) + "." + info->name()));
}

inline RowMatrix RandomPoints(int64_t n, int64_t dimension, std::mt19937_64& generator) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  RowMatrix x(n, dimension);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t d = 0; d < dimension; ++d) x(i, d) = uniform(generator);
  }
  return x;
}

// exp(-|x_i - x_j|^2) + noise_variance [i = j] of points in [-1, 1]^3: smooth, so that all of its
// conditioning comes from the noise.
inline RowMatrix RandomGram(int64_t n, double noise_variance, std::mt19937_64& generator) {
  const RowMatrix x = RandomPoints(n, 3, generator);
  RowMatrix k(n, n);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < n; ++j) {
      k(i, j) = std::exp(-(x.row(i) - x.row(j)).squaredNorm()) + (i == j ? noise_variance : 0.0);
    }
  }
  return k;
}

// `count` of 0..n-1, increasing.
inline std::vector<int64_t> RandomRows(int64_t n, int64_t count, std::mt19937_64& generator) {
  std::vector<int64_t> rows(n);
  std::iota(rows.begin(), rows.end(), int64_t{0});
  for (int64_t i = 0; i < count; ++i) {
    std::swap(rows[i], rows[i + static_cast<int64_t>(generator() % (n - i))]);
  }
  rows.resize(count);
  std::sort(rows.begin(), rows.end());
  return rows;
}

inline std::vector<int64_t> Complement(int64_t n, const std::vector<int64_t>& rows) {
  std::vector<int64_t> rest;
  for (int64_t i = 0; i < n; ++i) {
    if (!std::binary_search(rows.begin(), rows.end(), i)) rest.push_back(i);
  }
  return rest;
}

inline RowMatrix Select(const RowMatrix& k, const std::vector<int64_t>& rows) {
  const int64_t n = static_cast<int64_t>(rows.size());
  RowMatrix out(n, n);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < n; ++j) out(i, j) = k(rows[i], rows[j]);
  }
  return out;
}

// Replaces the factor by that of K, of which the lower triangle is read.
inline absl::Status Factorize(const RowMatrix& k, IncrementalCholesky& cholesky) {
  return cholesky.Factorize(k.rows(), [&](kernels::MatrixView<double> out) {
    for (int64_t i = 0; i < k.rows(); ++i) std::copy_n(k.row(i).data(), i + 1, out.row(i));
    return absl::OkStatus();
  });
}

inline IncrementalCholesky FactorOf(const RowMatrix& k) {
  IncrementalCholesky cholesky;
  EXPECT_TRUE(Factorize(k, cholesky).ok());
  return cholesky;
}

// f'(0) by the five-point rule with steps of h: off by h^4 / 30 times the fifth derivative.
template <typename F>
double FivePointSlope(const F& f, double h) {
  return (f(-2.0 * h) - 8.0 * f(-h) + 8.0 * f(h) - f(2.0 * h)) / (12.0 * h);
}

// |L L^T - K|_F in units of `order` eps |K|_F, order being the size of the largest matrix that L
// went through; 0 for an empty K.
inline double BackwardError(const RowMatrix& l, const RowMatrix& k, int64_t order) {
  if (k.rows() == 0) return 0.0;
  const double unit = static_cast<double>(order) * std::numeric_limits<double>::epsilon();
  return (l * l.transpose() - k).norm() / (unit * k.norm());
}

}  // namespace egosieve::gp
