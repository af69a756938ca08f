#include "vision/trajectory/ground_direction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;

constexpr size_t kPlaces = 400;                         // per view
constexpr double kFirstStep = 0.01, kLastStep = 0.001;  // rays
constexpr int kMostSteps = 40;

// A view's part of (GD1).
double LogEvidence(const GroundSearch& search, const Vector3d& direction) {
  const SpeedLikelihood likelihood = search.Likelihood(direction);
  const double top = *std::max_element(likelihood.begin(), likelihood.end());
  double sum = 0.0;
  for (int v = 0; v < kSpeeds; ++v) sum += std::exp(likelihood[v] - top);
  return top + std::log(0.5 * sum / kSpeeds + 0.5 * std::exp(likelihood[kSpeeds] - top));
}

}  // namespace

Vector3d DirectionByGround(const TravelPrior& prior, std::vector<GroundSearchView> views) {
  if (!MovesForwardOrBack(prior.direction)) return prior.direction;
  std::vector<GroundSearch> searches;
  for (GroundSearchView& view : views) {
    view.direction = prior.direction;
    searches.emplace_back(std::move(view), kPlaces);
  }
  const auto evidence = [&](const Vector3d& direction) {
    std::vector<double> parts(searches.size());
    kernels::ParallelFor(searches.size(),
                         [&](size_t k) { parts[k] = LogEvidence(searches[k], direction); });
    double sum = prior.LogDensity(direction);
    for (const double part : parts) sum += part;
    return sum;
  };
  constexpr std::array<std::array<double, 2>, 4> kSteps = {{{0, 1}, {0, -1}, {1, 0}, {-1, 0}}};
  Vector3d best = prior.direction;
  double most = evidence(best), step = kFirstStep;
  for (int k = 0; k < kMostSteps && step >= kLastStep; ++k) {
    Vector3d next = best;
    for (const auto& [across, down] : kSteps) {
      const Vector3d ray = best / best(2) + step * Vector3d(across, down, 0.0);
      const Vector3d tried = std::copysign(1.0, best(2)) * ray.normalized();
      const double value = evidence(tried);
      if (value > most) {
        most = value;
        next = tried;
      }
    }
    if (next == best) step *= 0.5;
    best = next;
  }
  return best;
}

}  // namespace egosieve::vision
