#include "gp/training/simulated_annealing.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

constexpr double kFirstTemperature = 0.1;  // in units of J
constexpr double kLastTemperature = 0.002;
constexpr double kInitialStep = 0.3;  // of the box's sides

double Uniform(std::mt19937_64& generator) {
  return (static_cast<double>(generator() >> 11) + 0.5) * 0x1p-53;  // in (0, 1)
}

double Normal(std::mt19937_64& generator) {
  const double radius = std::sqrt(-2.0 * std::log(Uniform(generator)));
  return radius * std::cos(2.0 * M_PI * Uniform(generator));
}

}  // namespace

absl::StatusOr<AnnealingResult> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds, int64_t evaluations,
    uint64_t seed) {
  EGOSIEVE_RETURN_IF_ERROR(bounds.Validate(static_cast<int64_t>(start.size())));
  std::mt19937_64 generator(seed);
  AnnealingResult best;
  best.theta = start;
  bounds.Clamp(best.theta);
  std::vector<double> now = best.theta;
  double now_objective = best.objective;
  for (int64_t k = 0; k < evaluations; ++k) {
    const double progress = static_cast<double>(k) / std::max<int64_t>(1, evaluations - 1);
    const double ratio = std::pow(kLastTemperature / kFirstTemperature, progress);
    std::vector<double> candidate = now;
    if (k > 0) {
      const size_t always = generator() % candidate.size();
      for (size_t i = 0; i < candidate.size(); ++i) {
        const double step = kInitialStep * std::sqrt(ratio) * Normal(generator);
        if (i == always || generator() % 2 == 0) {
          candidate[i] += step * (bounds.upper[i] - bounds.lower[i]);
        }
      }
      bounds.Clamp(candidate);
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const double value, objective(candidate));
    const double threshold = kFirstTemperature * ratio * std::log(Uniform(generator));
    if (value >= now_objective || value - now_objective >= threshold) {
      now = candidate;
      now_objective = value;
    }
    if (value > best.objective) {
      best.theta = candidate;
      best.objective = value;
    }
  }
  return best;
}

}  // namespace egosieve::gp
