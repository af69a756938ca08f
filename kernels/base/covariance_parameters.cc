#include "kernels/base/covariance_parameters.h"

#include <cmath>
#include <string>

#include "kernels/base/argument_checks.h"

namespace egosieve::kernels {

int64_t CovarianceParameters::input_dimension() const {
  if (dimension != 0) return dimension;
  return function.description().DimensionOf(static_cast<int64_t>(scales.size()));
}

absl::Status CovarianceParameters::Validate() const {
  const int64_t inputs = input_dimension();
  const std::string name(function.text());
  EGOSIEVE_REQUIRE(InvalidArgument, inputs >= 1 && inputs <= kMaxInputDimension,
                   "scales: %d values of %s give input dimension %d; it must be from 1 to %d",
                   scales.size(), name, inputs, kMaxInputDimension);
  if (const int64_t least = function.description().LeastDimension(); least > inputs) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s has column %d; there are %d inputs", name, least - 1, inputs));
  }
  const int64_t expected = function.description().ScaleCount(inputs);
  EGOSIEVE_REQUIRE(InvalidArgument, static_cast<int64_t>(scales.size()) == expected,
                   "scales: %d values; %s of %d inputs has %d", scales.size(), name, inputs,
                   expected);
  for (size_t i = 0; i < scales.size(); ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument, scales[i] > 0.0 && !std::isinf(scales[i]),
                     "scales[%d] = %g; it must be finite and positive", i, scales[i]);
  }
  EGOSIEVE_REQUIRE(InvalidArgument, signal_stddev > 0.0 && !std::isinf(signal_stddev),
                   "signal_stddev = %g; it must be finite and positive", signal_stddev);
  return absl::OkStatus();
}

}  // namespace egosieve::kernels
