#include "vision/labelling/label_rule.h"

#include <algorithm>
#include <cmath>

#include "vision/statistics/robust_scale.h"

namespace egosieve::vision {
namespace {

constexpr double kPi = 3.14159265358979323846;

double Posterior(double d, double sigma, double share, const MixtureOptions& options) {
  const double gaussian = std::exp(-0.5 * d * d / (sigma * sigma));
  const double radius = options.range_pixels;
  double static_density, dynamic_density;
  if (options.residual_dimension == 1) {
    static_density = gaussian * 2.0 / (sigma * std::sqrt(2.0 * kPi));
    dynamic_density = 1.0 / radius;
  } else {
    static_density = gaussian / (2.0 * kPi * sigma * sigma);
    dynamic_density = 1.0 / (kPi * radius * radius);
  }
  return share * dynamic_density / (share * dynamic_density + (1.0 - share) * static_density);
}

}  // namespace

void ReduceToShortFlow(const std::vector<double>& lengths_pixels, double share, double floor_pixels,
                       std::vector<double>& distances) {
  for (size_t i = 0; i < distances.size(); ++i) {
    distances[i] /= std::hypot(1.0, share * lengths_pixels[i] / floor_pixels);
  }
}

std::vector<double> ScaledMedianLabels(const std::vector<double>& distances, double noise_pixels,
                                       double multiple) {
  std::vector<double> labels;
  labels.reserve(distances.size());
  for (const double d : distances) labels.push_back(std::min(1.0, d / (multiple * noise_pixels)));
  return labels;
}

MixtureLabels EstimateMixtureLabels(const std::vector<double>& distances,
                                    const MixtureState& previous, const MixtureOptions& options) {
  MixtureLabels result;
  result.state = previous;
  if (distances.empty()) return result;
  const double n = static_cast<double>(distances.size());
  const double dimension = options.residual_dimension;
  const bool has_memory = previous.noise_pixels > 0.0;
  const double memory = has_memory ? options.memory_share * n : 0.0;
  constexpr double kLeastShare = 1e-3;  // keeps both components of the mixture possible

  double sigma = RobustScale(distances, options.noise_floor_pixels);
  double share = has_memory ? previous.dynamic_share : 0.2;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    double dynamic = 0.0, squares = 0.0;
    for (const double d : distances) {
      const double p = Posterior(d, sigma, share, options);
      dynamic += p;
      squares += p < 1.0 ? (1.0 - p) * d * d : 0.0;
    }
    const double variance =
        (squares / dimension + memory * previous.noise_pixels * previous.noise_pixels) /
        std::max(n - dynamic + memory, 1e-9);
    sigma = std::max(options.noise_floor_pixels, std::sqrt(variance));
    share = std::clamp((dynamic + memory * previous.dynamic_share) / (n + memory), kLeastShare,
                       1.0 - kLeastShare);
  }
  result.state = {sigma, share};
  result.probability.reserve(distances.size());
  for (const double d : distances)
    result.probability.push_back(Posterior(d, sigma, share, options));
  return result;
}

}  // namespace egosieve::vision
