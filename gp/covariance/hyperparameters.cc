#include "gp/covariance/hyperparameters.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

// Calls visit(group) for every scale of the function, in order.
template <typename Visit>
void ForEachScale(CovarianceFunction function, int64_t input_dimension, const Visit& visit) {
  for (const kernels::ScaleGroup& group : function.description().scale_groups()) {
    for (int64_t i = 0; i < group.ScaleCount(input_dimension); ++i) visit(group);
  }
}

}  // namespace

absl::Status Hyperparameters::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(covariance.Validate());
  return kernels::CheckOptions({{"noise_stddev", noise_stddev, kernels::IsPositive(noise_stddev),
                                 "be finite and positive"}});
}

std::vector<double> ToLogarithms(const Hyperparameters& hyperparameters) {
  std::vector<double> theta;
  theta.reserve(hyperparameters.count());
  for (const double scale : hyperparameters.covariance.scales) theta.push_back(std::log(scale));
  theta.push_back(std::log(hyperparameters.covariance.signal_stddev));
  theta.push_back(std::log(hyperparameters.noise_stddev));
  return theta;
}

absl::StatusOr<Hyperparameters> FromLogarithms(const Hyperparameters& like,
                                               absl::Span<const double> theta) {
  EGOSIEVE_REQUIRE(InvalidArgument, static_cast<int64_t>(theta.size()) == like.count(),
                   "theta has %d values; it holds %d scales, log sigma_f and log sigma_n",
                   theta.size(), like.covariance.scales.size());
  Hyperparameters hyperparameters = like;
  std::vector<double>& scales = hyperparameters.covariance.scales;
  for (size_t i = 0; i < scales.size(); ++i) scales[i] = std::exp(theta[i]);
  hyperparameters.covariance.signal_stddev = std::exp(theta[scales.size()]);
  hyperparameters.noise_stddev = std::exp(theta[scales.size() + 1]);
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  return hyperparameters;
}

Hyperparameters DefaultHyperparameters(CovarianceFunction function, int64_t input_dimension) {
  Hyperparameters hyperparameters;
  hyperparameters.covariance.function = function;
  hyperparameters.covariance.dimension = input_dimension;
  ForEachScale(function, input_dimension, [&](const kernels::ScaleGroup& group) {
    hyperparameters.covariance.scales.push_back(group.initial);
  });
  return hyperparameters;
}

HyperparameterBounds HyperparameterBounds::Default(CovarianceFunction function,
                                                   int64_t input_dimension) {
  HyperparameterBounds bounds;
  ForEachScale(function, input_dimension, [&](const kernels::ScaleGroup& group) {
    bounds.lower.push_back(group.lower_log);
    bounds.upper.push_back(group.upper_log);
  });
  bounds.lower.insert(bounds.lower.end(), {std::log(0.2), std::log(0.1)});
  bounds.upper.insert(bounds.upper.end(), {std::log(5.0), std::log(1.5)});
  return bounds;
}

void HyperparameterBounds::Clamp(std::vector<double>& theta) const {
  for (size_t i = 0; i < theta.size(); ++i) theta[i] = std::clamp(theta[i], lower[i], upper[i]);
}

bool HyperparameterBounds::Contains(absl::Span<const double> theta) const {
  if (theta.size() != lower.size()) return false;
  for (size_t i = 0; i < theta.size(); ++i) {
    if (!(theta[i] >= lower[i] && theta[i] <= upper[i])) return false;
  }
  return true;
}

absl::Status HyperparameterBounds::Validate(int64_t count) const {
  EGOSIEVE_REQUIRE(
      InvalidArgument,
      static_cast<int64_t>(lower.size()) == count && static_cast<int64_t>(upper.size()) == count,
      "bounds hold %d and %d values; there are %d hyperparameters", lower.size(), upper.size(),
      count);
  for (int64_t i = 0; i < count; ++i) {
    EGOSIEVE_REQUIRE(
        InvalidArgument, std::isfinite(lower[i]) && std::isfinite(upper[i]) && lower[i] <= upper[i],
        "bounds[%d] = [%g, %g]; they must be finite and in order", i, lower[i], upper[i]);
  }
  return absl::OkStatus();
}

Hyperparameters RandomHyperparameters(CovarianceFunction function, int64_t input_dimension,
                                      const HyperparameterBounds& bounds, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<double> theta;
  for (size_t i = 0; i < bounds.lower.size(); ++i) {
    const double unit = static_cast<double>(generator() >> 11) * 0x1p-53;
    theta.push_back(bounds.lower[i] + unit * (bounds.upper[i] - bounds.lower[i]));
  }
  return *FromLogarithms(DefaultHyperparameters(function, input_dimension), theta);
}

double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x) {
  return covariance.signal_stddev * covariance.signal_stddev *
         covariance.function.description().Variance(covariance.scales.data(),
                                                    covariance.input_dimension(), x);
}

double LargestPriorVariance(const kernels::CovarianceParameters& covariance,
                            kernels::ConstMatrixView<double> x) {
  if (x.rows == 0) return covariance.signal_stddev * covariance.signal_stddev;
  double largest = 0.0;
  for (int64_t i = 0; i < x.rows; ++i) {
    largest = std::max(largest, PriorVariance(covariance, x.row(i)));
  }
  return largest;
}

}  // namespace egosieve::gp
