#include "tools/embed/c/model_options.h"

#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/embed/c/options.h"

namespace egosieve::embed {
namespace {

static_assert(EGOSIEVE_MAX_DIMENSION == kernels::kMaxInputDimension);
static_assert(EGOSIEVE_ZERO_MEAN == static_cast<int>(gp::MeanFunction::kZero) &&
              EGOSIEVE_CONSTANT_MEAN == static_cast<int>(gp::MeanFunction::kConstant) &&
              EGOSIEVE_LINEAR_MEAN == static_cast<int>(gp::MeanFunction::kLinear));

absl::StatusOr<kernels::CovarianceFunction> CovarianceOf(const egosieve_gp_options& options) {
  const std::string text = options.covariance_text == nullptr ? "" : options.covariance_text;
  if (!text.empty() && options.covariance == EGOSIEVE_SQUARED_EXPONENTIAL) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "options.covariance = %d and covariance_text = \"%s\"; set one", options.covariance, text));
  }
  if (!text.empty() && options.covariance == EGOSIEVE_ARCSINE) {
    return kernels::CovarianceFunction::Parse(text);
  }
  switch (options.covariance) {
    case EGOSIEVE_ARCSINE:
      return kernels::CovarianceFunction::kArcsine;
    case EGOSIEVE_SQUARED_EXPONENTIAL:
      return kernels::CovarianceFunction::kSquaredExponential;
    case EGOSIEVE_NAMED_COVARIANCE:
      EGOSIEVE_RETURN_IF_ERROR(CheckPointer("options.covariance_text", options.covariance_text));
      return kernels::CovarianceFunction::Parse(text);
    default:
      return absl::InvalidArgumentError(
          absl::StrFormat("options.covariance = %d; it must be EGOSIEVE_ARCSINE, "
                          "EGOSIEVE_SQUARED_EXPONENTIAL or EGOSIEVE_NAMED_COVARIANCE",
                          options.covariance));
  }
}

}  // namespace

absl::StatusOr<gp::Hyperparameters> HyperparametersOf(const egosieve_gp_options& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::CovarianceFunction function, CovarianceOf(options));
  if (options.mean < EGOSIEVE_ZERO_MEAN || options.mean > EGOSIEVE_LINEAR_MEAN) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.mean = %d; it must be EGOSIEVE_ZERO_MEAN, EGOSIEVE_CONSTANT_MEAN "
                        "or EGOSIEVE_LINEAR_MEAN",
                        options.mean));
  }
  if (options.dimension < 1 || options.dimension > EGOSIEVE_MAX_DIMENSION) {
    return absl::InvalidArgumentError(absl::StrFormat("options.dimension = %d; it must be 1 to %d",
                                                      options.dimension, EGOSIEVE_MAX_DIMENSION));
  }
  gp::Hyperparameters hyperparameters = gp::DefaultHyperparameters(function, options.dimension);
  std::vector<double>& scales = hyperparameters.covariance.scales;
  const int64_t expected = options.scales == nullptr ? 0 : static_cast<int64_t>(scales.size());
  if (options.scale_count != expected) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.scale_count = %d; %s of %d inputs has %d scales",
                        options.scale_count, function.text(), options.dimension, scales.size()));
  }
  if (options.scales != nullptr) scales.assign(options.scales, options.scales + expected);
  hyperparameters.covariance.signal_stddev = options.signal_stddev;
  hyperparameters.noise_stddev = options.noise_stddev;
  hyperparameters.mean = static_cast<gp::MeanFunction>(options.mean);
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  return hyperparameters;
}

absl::StatusOr<std::optional<gp::SparseModelOptions>> SparseOptionsOf(
    const egosieve_gp_options& options) {
  if (options.approximation == EGOSIEVE_EXACT) return std::nullopt;
  if (options.approximation != EGOSIEVE_DTC && options.approximation != EGOSIEVE_FITC) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.approximation = %d; it must be EGOSIEVE_EXACT, EGOSIEVE_DTC or "
                        "EGOSIEVE_FITC",
                        options.approximation));
  }
  gp::SparseModelOptions sparse;
  sparse.approximation = options.approximation == EGOSIEVE_DTC ? gp::SparseApproximation::kDtc
                                                               : gp::SparseApproximation::kFitc;
  sparse.inducing_points = options.inducing_points;
  EGOSIEVE_RETURN_IF_ERROR(sparse.Validate());
  return sparse;
}

absl::StatusOr<kernels::DensePosteriorOptions> PosteriorOptionsOf(
    const egosieve_gp_options& options) {
  kernels::DensePosteriorOptions posterior;  // the device's own cap
  if (options.memory_cap_bytes < 0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "options.memory_cap_bytes = %d; it must not be negative", options.memory_cap_bytes));
  }
  if (options.memory_cap_bytes > 0) posterior.memory_cap_bytes = options.memory_cap_bytes;
  return posterior;
}

}  // namespace egosieve::embed
