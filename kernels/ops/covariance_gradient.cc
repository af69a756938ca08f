#include "kernels/ops/covariance_gradient.h"

#include <string>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_covariance.h"
#include "kernels/reference/covariance.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {

absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> w) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("w", w, x.rows, x.rows));
  for (int64_t i = 0; i < w.rows; ++i) {
    // Only the lower triangle is read, so only its values must be finite.
    const absl::Status finite = CheckFinite("w", ConstMatrixView<double>(w.row(i), 1, i + 1));
    if (!finite.ok()) {
      return absl::InvalidArgumentError("row " + std::to_string(i) +
                                        " of w: " + std::string(finite.message()));
    }
  }
  if (context.is_reference() || !context.info().float64) {
    return reference::CovarianceGradient(parameters, x, w);
  }
  return opencl::CovarianceGradient(context, parameters, x, x, w, true);
}

absl::StatusOr<std::vector<double>> CrossCovarianceGradient(Context& context,
                                                            const CovarianceParameters& parameters,
                                                            ConstMatrixView<double> x,
                                                            ConstMatrixView<double> z,
                                                            ConstMatrixView<double> w) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("z", parameters, z));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("w", w, x.rows, z.rows));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("w", w));
  if (context.is_reference() || !context.info().float64) {
    return reference::CrossCovarianceGradient(parameters, x, z, w);
  }
  return opencl::CovarianceGradient(context, parameters, x, z, w, false);
}

absl::StatusOr<std::vector<double>> VarianceGradient(const CovarianceParameters& parameters,
                                                     ConstMatrixView<double> x,
                                                     absl::Span<const double> weights) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  if (static_cast<int64_t>(weights.size()) != x.rows) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d weights for %d points", weights.size(), x.rows));
  }
  return reference::VarianceGradient(parameters, x, weights.data());
}

}  // namespace egosieve::kernels
