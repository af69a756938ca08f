// The weights that every prediction starts from, computed from a factor of K_y and targets.
//
//   H (n x q): rows h(x_i) of the mean function;  Y (n x k): the targets of k outputs
//   W = K_y^-1 H,   A = H^T W = M M^T                                                        (W1)
//   B = A^-1 W^T Y,   alpha = K_y^-1 (Y - H B) = P Y,   P = K_y^-1 - W A^-1 W^T              (W2)
//   mean(x) = alpha^T k* + B^T h(x)                                                          (W3)
//   variance(x) = k** - |L^-1 k*|^2 + |M^-1 r|^2,   r = h(x) - W^T k*                        (W4)
//   log p(y) = -1/2 y.alpha - sum_i log L_ii - sum_j log M_jj - (n - q) / 2 log 2 pi         (W5)
//
// With the zero mean (q = 0) these are R & W's 2.25 to 2.30. (W5) is for one output; for k outputs
// the values are added, since outputs are independent given the hyperparameters. With a mean
// function it is the restricted likelihood, which does not depend on the mean's coefficients.
//
// Cost: 2 (k + q) n^2 flops, twice the first for q > 0. Reference: Rasmussen & Williams (2006), 2.7
// (eqs. 2.41, 2.42, 2.45 in the limit of B^-1 and b to 0).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "gp/covariance/mean_function.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"

namespace egosieve::gp {

struct RegressionWeights {
  MeanFunction mean = MeanFunction::kZero;
  int64_t points = 0;                 // n
  int64_t outputs = 1;                // k
  int64_t basis = 0;                  // q
  std::vector<double> alpha;          // n x k
  std::vector<double> coefficients;   // B, q x k
  std::vector<double> basis_weights;  // W, n x q
  std::vector<double> information;    // M, q x q, lower
  // False if the points do not determine B: fewer than q, or on a line or plane. Then only W and
  // the sizes are set.
  bool determined = true;

  // FailedPrecondition if B is not determined.
  absl::Status CheckDetermined() const;

  // Adds B^T h(x) to `means` (k values).
  template <typename Input>
  void AddMeanFunction(int64_t dimension, const Input* x, double* means) const;

  // r := M^-1 r (q values); returns its squared norm, 0 for q = 0.
  double SolveInformation(double* r) const;
  // Writes M^-1 r(x) to `r`, where `sums` holds W^T k*; returns its squared norm.
  double ReducedBasis(int64_t dimension, const double* x, const double* sums, double* r) const;

  // Rows M^-1 w_i, n x q: their product with their transpose is W A^-1 W^T.
  std::vector<double> ReducedRows() const;

  // sum_j log M_jj.
  double HalfLogDeterminant() const;
};

// A factor of a posterior, L or R, n x n, and what keeps it in memory; of FactorKind::kNone its rows
// are the number of points.
struct SharedFactor {
  kernels::FactorKind kind = kernels::FactorKind::kCholesky;
  kernels::ConstMatrixView<double> values;
  std::shared_ptr<const void> memory;
};

// factor: L, n x n; inputs: n x D; targets: n x k.
RegressionWeights SolveWeights(kernels::ConstMatrixView<double> factor, MeanFunction mean,
                               kernels::ConstMatrixView<double> inputs,
                               kernels::ConstMatrixView<double> targets);

// All memory that SolveWeights needs, for changes after which nothing may fail.
struct WeightsMemory {
  WeightsMemory(MeanFunction mean, int64_t dimension, int64_t points, int64_t outputs);

  RegressionWeights weights;   // arrays of their final sizes
  std::vector<double> basis;   // H, n x q
  std::vector<double> floors;  // of M's pivots, q
};

// The same in this memory, of the same D, n and k: throws nothing.
RegressionWeights SolveWeights(kernels::ConstMatrixView<double> factor,
                               kernels::ConstMatrixView<double> inputs,
                               kernels::ConstMatrixView<double> targets, WeightsMemory memory);

// out (k values) := sums over j of k_j weights(j, .), in the order of j.
void WeightedSums(const double* k, const std::vector<double>& weights, int64_t points,
                  int64_t columns, double* out);

}  // namespace egosieve::gp
