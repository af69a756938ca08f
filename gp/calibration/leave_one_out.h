// Leave-one-out predictions of a Gaussian process from one factor (paper, eq. 7; Rasmussen &
// Williams, eqs. 5.10-5.12): for every point i, the prediction of y_i by all the others.
//
//   mu_i = y_i - alpha_i / [K^-1]_ii,   s_i^2 = 1 / [K^-1]_ii,   alpha = K^-1 y          (1)
//
// K holds the noise, so s_i^2 is the variance of y_i; that of f_i is s_i^2 - sigma_n^2. The
// diagonal of K^-1 costs n^3 / 3 flops for all points, and about m n^2 for m of them.
#ifndef EGOSIEVE_GP_CALIBRATION_LEAVE_ONE_OUT_H_
#define EGOSIEVE_GP_CALIBRATION_LEAVE_ONE_OUT_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/incremental_cholesky.h"

namespace egosieve::gp {

struct LeaveOneOut {
  std::vector<int64_t> rows;
  std::vector<double> mean;             // mu_i
  std::vector<double> target_variance;  // s_i^2, of y

  // The variances of f: s_i^2 - noise_variance, not below 0.
  std::vector<double> LatentVariance(double noise_variance) const;
  // sum_i log N(y_i; mu_i, s_i^2), targets: all n.
  double LogProbability(absl::Span<const double> targets) const;
};

// rows: increasing indices in [0, n); empty means all. alpha = K^-1 targets. InvalidArgument on
// sizes that differ or rows out of range.
absl::StatusOr<LeaveOneOut> ComputeLeaveOneOut(const IncrementalCholesky& factor,
                                               absl::Span<const double> targets,
                                               absl::Span<const double> alpha,
                                               absl::Span<const int64_t> rows = {});

// Up to `count` of the rows 0..n-1, increasing, stratified: each class (target >= 0 or below) gives
// a share in proportion, but the rarer no less than `minimum_class_share` of the sample as far as
// it has points. Seeded.
std::vector<int64_t> StratifiedSample(absl::Span<const double> targets, int64_t count,
                                      double minimum_class_share, uint64_t seed);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_CALIBRATION_LEAVE_ONE_OUT_H_
