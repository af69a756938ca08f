#include "vision/trajectory/ground_speed.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {
namespace {

constexpr double kDrift = 0.16;         // of log v, per square root of a second
constexpr double kAcceleration = 2.3;   // heights per second^2: braking at 3 m/s^2
constexpr double kMemorySeconds = 1.5;  // lane marks pass at shorter intervals
constexpr double kFrameCorrelation = 3.0;
constexpr double kMostNone = 0.1, kMostDeviation = 0.25;  // limits of a known speed

double StepOfLog() { return std::log(kGreatestSpeed / kLeastSpeed) / (kSpeeds - 1); }

}  // namespace

double SpeedAt(int k) { return kLeastSpeed * std::exp(k * StepOfLog()); }

GroundSpeed::GroundSpeed() {
  probabilities_.fill(0.0);
  probabilities_[kSpeeds] = 1.0;
}

void GroundSpeed::Advance(double seconds, const SpeedLikelihood& likelihood) {
  const double forgotten = -std::expm1(-seconds / kMemorySeconds);
  Probabilities next;
  next.fill(forgotten * probabilities_[kSpeeds] / kSpeeds);
  next[kSpeeds] = (1.0 - forgotten) * probabilities_[kSpeeds];
  for (int from = 0; from < kSpeeds; ++from) {
    const double deviation = std::sqrt(seconds) * std::max(kDrift, kAcceleration / SpeedAt(from));
    std::array<double, kSpeeds> kernel;
    double sum = 0.0;
    for (int to = 0; to < kSpeeds; ++to) {
      const double z = (to - from) * StepOfLog() / deviation;
      sum += kernel[to] = std::exp(-0.5 * z * z);
    }
    const double kept = (1.0 - forgotten) * probabilities_[from];
    for (int to = 0; to < kSpeeds; ++to) next[to] += kept * kernel[to] / sum;
    next[kSpeeds] += forgotten * probabilities_[from];
  }
  const double top = *std::max_element(likelihood.begin(), likelihood.end());
  double sum = 0.0;
  for (int k = 0; k <= kSpeeds; ++k) {
    sum += next[k] *= std::exp((likelihood[k] - top) / kFrameCorrelation);
  }
  if (!(sum > 0.0) || !std::isfinite(sum)) return;
  for (double& probability : next) probability /= sum;
  probabilities_ = next;
}

double GroundSpeed::Low() const {
  const double known = 1.0 - probabilities_[kSpeeds];
  if (!(known >= 1.0 - kMostNone)) return 0.0;
  double mean = 0.0, square = 0.0;
  for (int k = 0; k < kSpeeds; ++k) {
    const double log_speed = std::log(SpeedAt(k));
    mean += probabilities_[k] / known * log_speed;
    square += probabilities_[k] / known * log_speed * log_speed;
  }
  const double deviation = std::sqrt(std::max(0.0, square - mean * mean));
  return deviation <= kMostDeviation ? std::exp(mean - deviation) : 0.0;
}

bool GroundSpeed::Restore(const Probabilities& probabilities) {
  double sum = 0.0;
  for (const double probability : probabilities) {
    if (!(probability >= 0.0)) return false;
    sum += probability;
  }
  if (!(std::abs(sum - 1.0) < 1e-6)) return false;
  probabilities_ = probabilities;
  return true;
}

}  // namespace egosieve::vision
