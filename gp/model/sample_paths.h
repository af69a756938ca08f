// Samples of the posterior as functions: pathwise conditioning, by Matheron's rule. A sample has
// its value at x whatever else is asked, and no covariance between queries is computed.
//
//   g(x) = sigma_f sqrt(m / F) sum_j (a_j cos w_j.(x - c) + b_j sin w_j.(x - c))              (PS1)
//   f(x) = g(x) + k(x, Z) v + h(x).b                                                          (PS2)
//   y(x) = f(x) + sigma_n e(x)                                                                (PS3)
//
// g is a sample of the prior: w_j are F frequencies of mass m (kernels/covariance/
// covariance_function.h), a_j, b_j ~ N(0, 1), c the centre of the points. v and b correct it by the
// points:
//
//   exact    Z = X, b and v are B and alpha of (W2) in gp/model/regression_weights.h for the targets
//            y - g(X) - e,  e_i ~ N(0, sigma_n^2 + v_i + jitter)                              (PS4)
//   sparse   Z = u, b = 0, v = L^-T (A^-1 c + L_A^-T z - L^-1 (g(u) + jitter^1/2 z')),
//            z, z' ~ N(0, I); L, A, c of (SP1), (SP3) in gp/model/sparse_solution.h           (PS5)
//
// e(x) of (PS3) follows from the bits of x. Each sample has frequencies of its own. So E g(x) g(x')
// = k(x, x'), and samples have the posterior's mean and covariance for any F. Only their
// distribution is a mixture of normal ones: given its frequencies, a sample's prior covariance
// differs from k by a deviation of at most sigma_f^2 m / sqrt(F).
//
// Cost for S samples of k outputs: 2 k S n^2 flops, and for each query F k S sines and cosines and n
// (D + k S) multiply-adds. Memory: k S (F (D + 2) + n) values and the results.
//
// Reference: Wilson et al. (2020), "Efficiently sampling functions from Gaussian process posteriors";
// Rahimi & Recht (2007), "Random features for large-scale kernel machines".
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/normal_samples.h"
#include "gp/model/float64_posterior.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct PathOptions {
  int64_t count = 1;            // S, samples of each output
  int64_t frequencies = 1024;   // F
  uint64_t seed = 0;            // sample s depends on it, s and k alone
  bool of_observation = false;  // y(x) instead of f(x)

  // InvalidArgument unless the count is not negative and F in [1, 2^20].
  absl::Status Validate() const;
};

// g of (PS1), a column for each sample of each output: sample s of output c is column c S + s.
class PriorPaths {
 public:
  // points: around whose centre phases are counted. Unimplemented for a covariance without spectral
  // mass, InvalidArgument for bad options.
  static absl::StatusOr<PriorPaths> Draw(const Hyperparameters& hyperparameters,
                                         kernels::ConstMatrixView<double> points, int64_t outputs,
                                         const PathOptions& options);

  int64_t columns() const { return static_cast<int64_t>(keys_.size()); }
  // values(i, column) += g(x_i).
  void AddTo(kernels::ConstMatrixView<double> x, kernels::MatrixView<double> values) const;
  // Further normal values of a column.
  NormalStream Numbers(int64_t column) const;
  // e(x) of (PS3).
  double NoiseAt(int64_t column, const double* x, int64_t dimension) const;

 private:
  std::vector<uint64_t> keys_;  // of the columns
  std::vector<double> centre_;  // c
  std::vector<double> waves_;   // w_j, sigma_f sqrt(m / F) (a_j, b_j): columns x F x (D + 2)
  int64_t frequencies_ = 0;
};

class SamplePaths {
 public:
  // points: Z, copied. update: v as alpha, b as coefficients, with a column for each of the prior's.
  SamplePaths(std::shared_ptr<kernels::Context> context, const Hyperparameters& hyperparameters,
              kernels::ConstMatrixView<double> points, PriorPaths prior,
              const RegressionWeights& update, bool of_observation);

  // (PS2) or (PS3) at M x D points, else InvalidArgument: M x (k S).
  absl::StatusOr<std::vector<double>> Evaluate(kernels::ConstMatrixView<double> points) const;

 private:
  PriorPaths prior_;
  Float64Posterior update_;  // k(x, Z) v + h(x).b is its mean
  double noise_stddev_;      // 0 for f
};

}  // namespace egosieve::gp
