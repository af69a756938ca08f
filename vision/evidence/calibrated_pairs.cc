#include "vision/evidence/calibrated_pairs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "vision/evidence/for_each_point.h"
#include "vision/trajectory/scatter.h"

namespace egosieve::vision {
namespace {

constexpr double kMostMovingRatio = 12.0;
constexpr double kSpeedChange = 0.5;  // of a mover between two pairs, a share of its speed

// Motion of a place away from its epipolar line, pixels per picture.
struct Drift {
  bool known = false;
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  double deviation = 0.0;
};

cv::Point2f PlaceOf(double x, double y) { return {static_cast<float>(x), static_cast<float>(y)}; }

StaticSegment SegmentOf(const PairLikelihood& likelihood) {
  const PairLikelihood::End &far = likelihood.farthest, &near = likelihood.nearest;
  return {PlaceOf(far.place(0), far.place(1)), PlaceOf(near.place(0), near.place(1)), far.scale,
          near.scale};
}

// log(exp(a) / 2 + exp(b) / 2)
double LogMean(double a, double b) {
  const double top = std::max(a, b);
  return top + std::log(0.5 * (std::exp(a - top) + std::exp(b - top)));
}

// The second part of (CP2).
double LogRatioOfDrift(const Drift& drift, const PairLikelihood& likelihood, double across,
                       double noise, int pictures, bool scatters) {
  const double mean = pictures * drift.pixels.dot(likelihood.normal);
  const double spread = pictures * std::hypot(drift.deviation, kSpeedChange * drift.pixels.norm());
  const double deviation = std::hypot(noise, spread);
  const double z = (across - mean) / deviation, z_static = across / noise;
  const double log_static = scatters ? LogScatterDensity(z_static) : LogNormalDensity(z_static);
  return LogNormalDensity(z) + std::log(noise / deviation) - log_static;
}

// Sets the drift if it is not known.
double LogRatio(const CalibratedPair& pair, const PointPair& place, bool is_unbounded,
                const Pinhole& camera, Drift& drift) {
  const PairLikelihood likelihood = LikelihoodOf(pair.motion, camera, place, !is_unbounded);
  const double across = camera.focal_pixels * likelihood.across;
  const double noise = pair.motion.noise_pixels;
  double ratio = likelihood.log_moving - likelihood.log_static;
  if (drift.known) {
    ratio = LogMean(ratio, LogRatioOfDrift(drift, likelihood, across, noise, pair.pictures,
                                           pair.motion.scatters));
  } else {
    drift = {true, across / pair.pictures * likelihood.normal, noise / std::abs(pair.pictures)};
  }
  ratio = std::clamp(ratio, -kMostMovingRatio, kMostMovingRatio);
  if (!pair.support || ratio <= 0.0) return ratio;
  const std::optional<double> seen = pair.support->LogRatioOnSegment(
      PlaceOf(place.x1, place.y1), PlaceOf(place.x2, place.y2), SegmentOf(likelihood));
  return std::min(ratio, seen.value_or(0.0));
}

}  // namespace

std::vector<std::vector<std::optional<double>>> CalibratedLogRatios(
    const std::vector<CalibratedPair>& pairs, const Pinhole& camera,
    const std::vector<bool>& is_unbounded) {
  std::vector<size_t> longest_first(pairs.size());
  std::iota(longest_first.begin(), longest_first.end(), size_t{0});
  std::stable_sort(longest_first.begin(), longest_first.end(), [&](size_t a, size_t b) {
    return std::abs(pairs[a].pictures) > std::abs(pairs[b].pictures);
  });
  std::vector<std::vector<std::optional<double>>> ratios(pairs.size());
  std::vector<Drift> drifts(pairs.empty() ? 0 : pairs[0].places.size());
  for (const size_t k : longest_first) {
    ratios[k].resize(drifts.size());
    ForEachPoint(drifts.size(), [&](size_t i) {
      const PointPair& place = pairs[k].places[i];
      if (!std::isfinite(place.x1 + place.y1 + place.x2 + place.y2)) return;
      ratios[k][i] =
          LogRatio(pairs[k], place, !is_unbounded.empty() && is_unbounded[i], camera, drifts[i]);
    });
  }
  return ratios;
}

}  // namespace egosieve::vision
