// Samples of joint normal distributions that share a covariance.
//
//   y_cs = mean_c + C z_cs,   C C^T = Sigma + jitter I,   z_cs ~ N(0, I)                        (1)
//
// for columns c of `mean` and samples s. z comes from normal_stream.h. Sample s depends on seed, M
// and k, but not on the number of samples or threads.
//
// The covariance of many inputs is singular to working precision if they are close together. It is
// first factored as it is. If a pivot is refused, the jitter increases by
// gp/linalg/jitter_sequence.h, whose unit is the largest of `prior_variances`. A pivot i counts as
// positive above M eps prior_variances[i], since Sigma_ii may be a small difference of such
// variances.
//
// Cost: M^3 / 3 flops for C and M^2 k S for the samples.
//
// Reference: Rasmussen & Williams (2006), A.2.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/aligned_matrix.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

struct NormalSamples {
  AlignedMatrix values;  // M x (k S): sample s of column c lies in column c S + s
  double jitter = 0.0;   // on Sigma's diagonal
};

// mean: M x k; covariance: M x M, lower triangle read; prior_variances: M. InvalidArgument if count
// is negative or a shape differs; FailedPrecondition if Sigma is not positive definite with the
// largest jitter.
absl::StatusOr<NormalSamples> SampleNormal(kernels::ConstMatrixView<double> mean,
                                           kernels::ConstMatrixView<double> covariance,
                                           absl::Span<const double> prior_variances, int64_t count,
                                           uint64_t seed);

}  // namespace egosieve::gp
