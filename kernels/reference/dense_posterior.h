// The dense posterior in plain float64 on the host, by the formulas of
// kernels/ops/dense_posterior.h. It is the reference of its tests and the device "reference". Cost:
// O(n D + n^2) per query with variances.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"

namespace egosieve::kernels::reference {

// Phi(x), the standard normal distribution function.
double NormalCdf(double x);

// Keeps copies of a PosteriorModel, which must be valid.
class DensePosterior {
 public:
  explicit DensePosterior(const PosteriorModel& model);

  // Outputs have M values each; null: not computed. Returns the number of clamped variances.
  template <typename Query, typename Real>
  int64_t Evaluate(ConstMatrixView<Query> queries, Real* mean, Real* variance,
                   Real* probability) const;

 private:
  // Replaces each column of `columns` (n x kTile, column-major) by L^-1 or R times it.
  void ApplyFactor(std::vector<double>& columns) const;

  CovarianceParameters covariance_;
  int64_t count_;
  std::vector<double> inputs_;  // n x D
  std::vector<double> alpha_;
  FactorKind factor_kind_;
  std::vector<double> factor_;  // n x n
  double squash_a_;
  double squash_b_;
};

}  // namespace egosieve::kernels::reference
