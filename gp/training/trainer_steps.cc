#include "gp/training/trainer_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

absl::StatusOr<std::vector<double>> Anneal(
    absl::FunctionRef<absl::StatusOr<double>(const std::vector<double>&)> objective,
    const std::vector<double>& start, const HyperparameterBounds& bounds, int64_t evaluations,
    uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<double> best = start;
  bounds.Clamp(best);
  std::vector<double> now = best;
  double best_objective = -std::numeric_limits<double>::infinity();
  double now_objective = best_objective;
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
    if (value > best_objective) {
      best = candidate;
      best_objective = value;
    }
  }
  return best;
}

void RpropStep(absl::Span<const double> gradient, const HyperparameterBounds& bounds,
               RpropState& state, std::vector<double>& theta) {
  constexpr double kInitialStep = 0.1, kMinimumStep = 1e-4, kMaximumStep = 0.5;
  if (state.steps.size() != theta.size()) {
    state.steps.assign(theta.size(), kInitialStep);
    state.previous_gradient.assign(theta.size(), 0.0);
  }
  for (size_t i = 0; i < theta.size(); ++i) {
    double slope = gradient[i];
    const double agreement = slope * state.previous_gradient[i];
    if (agreement > 0.0) {
      state.steps[i] = std::min(1.2 * state.steps[i], kMaximumStep);
    } else if (agreement < 0.0) {
      state.steps[i] = std::max(0.5 * state.steps[i], kMinimumStep);
      slope = 0.0;
    }
    if (slope > 0.0) theta[i] += state.steps[i];
    if (slope < 0.0) theta[i] -= state.steps[i];
    state.previous_gradient[i] = slope;
  }
  bounds.Clamp(theta);
}

}  // namespace egosieve::gp
