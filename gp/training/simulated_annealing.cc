#include "gp/training/simulated_annealing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

double Uniform(std::mt19937_64& generator) {
  return (static_cast<double>(generator() >> 11) + 0.5) * 0x1p-53;  // in (0, 1)
}

double Normal(std::mt19937_64& generator) {
  const double radius = std::sqrt(-2.0 * std::log(Uniform(generator)));
  return radius * std::cos(2.0 * M_PI * Uniform(generator));
}

}  // namespace

absl::Status AnnealingOptions::Validate() const {
  if (!(evaluations >= 0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("evaluations = %d; it must not be negative", evaluations));
  }
  if (!(last_temperature > 0.0 && first_temperature >= last_temperature &&
        std::isfinite(first_temperature))) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "first_temperature = %g, last_temperature = %g; they must be positive and falling",
        first_temperature, last_temperature));
  }
  if (!(initial_step > 0.0) || std::isinf(initial_step)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("initial_step = %g; it must be finite and positive", initial_step));
  }
  return absl::OkStatus();
}

absl::StatusOr<AnnealingResult> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds,
    const AnnealingOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(bounds.Validate(static_cast<int64_t>(start.size())));
  std::mt19937_64 generator(options.seed);
  AnnealingResult best;
  best.theta = start;
  bounds.Clamp(best.theta);
  best.objective = -std::numeric_limits<double>::infinity();
  std::vector<double> now = best.theta;
  double now_objective = best.objective;
  for (int64_t k = 0; k < options.evaluations; ++k) {
    const double progress = static_cast<double>(k) / std::max<int64_t>(1, options.evaluations - 1);
    const double ratio = std::pow(options.last_temperature / options.first_temperature, progress);
    std::vector<double> candidate = now;
    if (k > 0) {
      const size_t always = generator() % candidate.size();
      for (size_t i = 0; i < candidate.size(); ++i) {
        const double step = options.initial_step * std::sqrt(ratio) * Normal(generator);
        if (i == always || generator() % 2 == 0) {
          candidate[i] += step * (bounds.upper[i] - bounds.lower[i]);
        }
      }
      bounds.Clamp(candidate);
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const double value, objective(candidate));
    ++best.evaluations;
    const double threshold = options.first_temperature * ratio * std::log(Uniform(generator));
    if (value >= now_objective || value - now_objective >= threshold) {
      now = candidate;
      now_objective = value;
      ++best.accepted;
    }
    if (value > best.objective) {
      best.theta = candidate;
      best.objective = value;
    }
  }
  return best;
}

}  // namespace egosieve::gp
