// Leave-one-out predictions of a Gaussian process from one factor (paper, eq. 7; Rasmussen &
// Williams, eqs. 5.10-5.12): for every point i, the prediction of y_i by all the others.
//
//   mu_i = y_i - alpha_i / P_ii,   s_i^2 = 1 / P_ii,   alpha = P y                       (1)
//   log p(y_i | others) = -1/2 (log 2 pi s_i^2 + (y_i - mu_i)^2 / s_i^2)                 (2)
//
// P = K^-1, minus W A^-1 W^T of gp/model/regression_weights.h with a mean function. The mean's
// coefficients are then also those of the other points (Dubrule 1983, "Cross validation of kriging
// in a unique neighborhood"). K contains the noise, so s_i^2 is the variance of y_i; that of f_i is
// s_i^2 - sigma_n^2 - v_i. The diagonal of K^-1 costs n^3 / 3 flops for all points, and about m n^2
// for m of them.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/incremental_cholesky.h"

namespace egosieve::gp {

struct LeaveOneOut {
  std::vector<int64_t> rows;            // m of them
  int64_t outputs = 1;                  // k
  std::vector<double> mean;             // mu, m x k
  std::vector<double> target_variance;  // s^2 of y, m
  std::vector<double> noise_variances;  // v of the rows; empty: all 0

  // The variances of f, m values: s_i^2 - noise_variance - v_i, at least 0.
  std::vector<double> LatentVariance(double noise_variance) const;
  // (2), m x k; targets: all n x k.
  std::vector<double> LogDensities(absl::Span<const double> targets) const;
};

// rows: increasing indices in [0, n); empty: all. targets, alpha: n x k. mean_shares: the diagonal
// of W A^-1 W^T, n values; empty: the zero mean. InvalidArgument for rows out of range;
// FailedPrecondition if the other points do not determine a mean function.
absl::StatusOr<LeaveOneOut> ComputeLeaveOneOut(const IncrementalCholesky& factor,
                                               absl::Span<const double> targets,
                                               absl::Span<const double> alpha,
                                               absl::Span<const int64_t> rows = {},
                                               absl::Span<const double> mean_shares = {});

// A stratified sample of up to `count` of the rows 0..n-1, increasing. Each class (target >= 0, or
// below) gets a share in proportion to its size, but the rarer class at least `minimum_class_share`
// of the sample, if it has enough points. Seeded.
std::vector<int64_t> StratifiedSample(absl::Span<const double> targets, int64_t count,
                                      double minimum_class_share, uint64_t seed);

}  // namespace egosieve::gp
