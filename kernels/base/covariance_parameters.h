// The covariance functions that every operation of the library knows, and their parameters.
//
//   kArcsine (neural network; paper, eq. 5; Rasmussen & Williams eq. 4.29 has a factor 2/pi in
//   front, GPML's covNNone is the same with 2 Sigma = I / ell^2):
//
//     k(x, x') = sigma_f^2 asin( a.b / sqrt((1 + a.a)(1 + b.b)) ),
//     a = sqrt(2) diag(w) (1, x),  b = sqrt(2) diag(w) (1, x'),      scales = (w_0, ..., w_D)
//
//   kSquaredExponential:
//
//     k(x, x') = sigma_f^2 exp(-1/2 sum_d ((x_d - x'_d) / l_d)^2),   scales = (l_1, ..., l_D)
//
// Gradients are with respect to the logarithms: (log scales..., log sigma_f), in that order.
#ifndef EGOSIEVE_KERNELS_BASE_COVARIANCE_PARAMETERS_H_
#define EGOSIEVE_KERNELS_BASE_COVARIANCE_PARAMETERS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"

namespace egosieve::kernels {

inline constexpr int kMaxInputDimension = 32;

enum class CovarianceFunction { kArcsine, kSquaredExponential };

struct CovarianceParameters {
  CovarianceFunction function = CovarianceFunction::kArcsine;
  std::vector<double> scales;  // arcsine: D + 1 weights, bias first; otherwise: D length-scales
  double signal_stddev = 1.0;  // sigma_f

  // D; the size of `scales` less the arcsine's bias.
  int64_t input_dimension() const;
  // InvalidArgument, naming field and value, unless 1 <= D <= kMaxInputDimension and every
  // parameter is finite and positive.
  absl::Status Validate() const;
};

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_COVARIANCE_PARAMETERS_H_
