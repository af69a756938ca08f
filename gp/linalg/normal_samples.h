// Samples of joint normal distributions that share a covariance.
//
//   y_cs = mean_c + C z_cs,   C C^T = Sigma + jitter I,   z_cs ~ N(0, I)                        (1)
//
// for columns c of `mean` and samples s. z follows from a key: splitmix64, counted from the key, by the
// Box-Muller transform. Sample s depends on seed, M and k, but not on the number of samples or threads.
//
// The covariance of many inputs is singular to working precision if they are close together. It is
// first factored as it is. If a pivot is refused, the jitter increases by
// gp/linalg/not_positive_definite.h, whose unit is the largest of `prior_variances`. A pivot i counts as
// positive above M eps prior_variances[i], since Sigma_ii may be a small difference of such
// variances.
//
// Cost: M^3 / 3 flops for C and M^2 k S for the samples.
//
// References: Rasmussen & Williams (2006), A.2; Box & Muller (1958); Steele, Lea & Flood (2014).
#pragma once

#include <cmath>
#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/aligned_matrix.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/splitmix.h"

namespace egosieve::gp {

struct NormalSamples {
  AlignedMatrix values;  // M x (k S): sample s of column c lies in column c S + s
  double jitter = 0.0;   // on Sigma's diagonal
};

// mean: M x k; covariance: M x M, lower triangle read; prior_variances: M. FailedPrecondition if Sigma
// is not positive definite with the largest jitter.
absl::StatusOr<NormalSamples> SampleNormal(kernels::ConstMatrixView<double> mean,
                                           kernels::ConstMatrixView<double> covariance,
                                           absl::Span<const double> prior_variances, int64_t count,
                                           uint64_t seed);

// Pair number `pair` of two independent normal values.
inline void NormalPair(uint64_t key, uint64_t pair, double& first, double& second) {
  const auto uniform = [key](uint64_t place) {  // in (0, 1)
    const uint64_t bits = kernels::SplitMix(key + kernels::kSplitMixStep * place);
    return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
  };
  const double radius = std::sqrt(-2.0 * std::log(uniform(2 * pair)));
  const double angle = 2.0 * M_PI * uniform(2 * pair + 1);
  first = radius * std::cos(angle);
  second = radius * std::sin(angle);
}

// The values one after another.
class NormalStream {
 public:
  explicit NormalStream(uint64_t key) : key_(key) {}

  double operator()() {
    if (count_++ % 2 == 1) return second_;
    double first;
    NormalPair(key_, count_ / 2, first, second_);
    return first;
  }

 private:
  uint64_t key_;
  uint64_t count_ = 0;
  double second_ = 0.0;
};

}  // namespace egosieve::gp
