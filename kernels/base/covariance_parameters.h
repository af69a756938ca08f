// A covariance function with its parameters:
//
//   k(x, x') = sigma_f^2 f(x, x'; scales)
//
// f is any of kernels/covariance/covariance_function.h. Gradients are with respect to the
// logarithms: (log scales..., log sigma_f), in that order.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

struct CovarianceParameters {
  CovarianceFunction function = CovarianceFunction::kArcsine;
  std::vector<double> scales;  // as the function expects them; arcsine: D + 1 weights, bias first
  double signal_stddev = 1.0;  // sigma_f
  // D, if it does not follow from the number of scales; 0: it does.
  int64_t dimension = 0;

  // D; 0 if it is not determined.
  int64_t input_dimension() const;
  // InvalidArgument, naming field and value, unless 1 <= D <= kMaxInputDimension, the function's
  // columns are below D, the number of scales is the function's for D inputs, and every parameter
  // is finite and positive.
  absl::Status Validate() const;
};

}  // namespace egosieve::kernels
