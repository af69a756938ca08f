#include "kernels/base/covariance_parameters.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace egosieve::kernels {

int64_t CovarianceParameters::input_dimension() const {
  const int64_t count = static_cast<int64_t>(scales.size());
  return function == CovarianceFunction::kArcsine ? count - 1 : count;
}

absl::Status CovarianceParameters::Validate() const {
  const int64_t dimension = input_dimension();
  if (dimension < 1 || dimension > kMaxInputDimension) {
    return absl::InvalidArgumentError(
        absl::StrFormat("scales: %d values give input dimension %d; it must be from 1 to %d",
                        scales.size(), dimension, kMaxInputDimension));
  }
  for (size_t i = 0; i < scales.size(); ++i) {
    if (!(scales[i] > 0.0) || std::isinf(scales[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("scales[%d] = %g; it must be finite and positive", i, scales[i]));
    }
  }
  if (!(signal_stddev > 0.0) || std::isinf(signal_stddev)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("signal_stddev = %g; it must be finite and positive", signal_stddev));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::kernels
