#include "vision/trajectory/ground_speed.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/trajectory/camera_step.h"

namespace egosieve::vision {
namespace {

constexpr double kDrift = 0.16;        // of log v, per square root of a second
constexpr double kAcceleration = 2.3;  // heights per second^2: braking at 3 m/s^2
constexpr double kShown = 0.5;
constexpr double kFrameCorrelation = 2.0;
constexpr double kLeastDeviation = 0.3;  // of a change, in steps of the state
constexpr double kMostDeviation = 0.5;   // of the logarithm of a known speed

double RangeOfLog() { return std::log(kGreatestSpeed / kLeastSpeed); }
double StepOfLog() { return RangeOfLog() / (kSpeeds - 1); }

// log p(v_t | v_(t-1), f) up to a constant is -(log v_t - log v_(t-1) - mean)^2 / (2 deviation^2).
struct Change {
  double mean = 0.0, deviation = 0.0;
};

// (GS1) and (GS2) together.
Change ChangeFrom(double speed, double seconds, double faster) {
  const double drift = std::sqrt(seconds) * std::max(kDrift, kAcceleration / speed);
  if (!(faster > 0.0)) return {0.0, drift};
  const double gain = drift * drift / (drift * drift + kOnwardError * kOnwardError);
  return {gain * std::log(faster), std::sqrt(gain) * kOnwardError};
}

// The logarithms of (GS3) and (GS4).
double LogLikelihood(const GroundObservation& observation, int k) {
  const double ground = observation.pictures[k], none = observation.pictures[kSpeeds];
  const double top = std::max(ground, none);
  const double by_pictures =
      top + std::log(kShown * std::exp(ground - top) + (1.0 - kShown) * std::exp(none - top));
  if (!(observation.speed > 0.0)) return by_pictures;
  const double z = std::log(observation.speed / SpeedAt(k)) / kGroundError;
  const double density =
      std::exp(-0.5 * z * z) / (kGroundError * std::sqrt(2.0 * std::numbers::pi));
  return by_pictures + std::log(kShown * density + (1.0 - kShown) / RangeOfLog());
}

}  // namespace

double SpeedAt(int k) { return kLeastSpeed * std::exp(k * StepOfLog()); }

GroundSpeed::GroundSpeed() { state_.probabilities.fill(1.0 / kSpeeds); }

void GroundSpeed::Advance(double seconds, const GroundObservation& observation) {
  const double faster = state_.onward * state_.seconds / seconds;
  state_.onward = 0.0;
  state_.seconds = seconds;
  Probabilities next{};
  for (int from = 0; from < kSpeeds; ++from) {
    const Change change = ChangeFrom(SpeedAt(from), seconds, faster);
    const double expected = std::clamp(from + change.mean / StepOfLog(), 0.0, kSpeeds - 1.0);
    const double deviation = std::max(change.deviation / StepOfLog(), kLeastDeviation);
    Probabilities kernel;
    double sum = 0.0;
    for (int to = 0; to < kSpeeds; ++to) {
      const double z = (to - expected) / deviation;
      sum += kernel[to] = std::exp(-0.5 * z * z);
    }
    for (int to = 0; to < kSpeeds; ++to) next[to] += state_.probabilities[from] * kernel[to] / sum;
  }
  Probabilities logs;
  for (int k = 0; k < kSpeeds; ++k) logs[k] = LogLikelihood(observation, k) / kFrameCorrelation;
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (int k = 0; k < kSpeeds; ++k) sum += next[k] *= std::exp(logs[k] - top);
  if (!(sum > 0.0) || !std::isfinite(sum)) return;
  for (double& probability : next) probability /= sum;
  state_.probabilities = next;
}

double GroundSpeed::Low() const {
  double mean = 0.0, square = 0.0;
  for (int k = 0; k < kSpeeds; ++k) {
    const double log_speed = std::log(SpeedAt(k));
    mean += state_.probabilities[k] * log_speed;
    square += state_.probabilities[k] * log_speed * log_speed;
  }
  const double deviation = std::sqrt(std::max(0.0, square - mean * mean));
  return deviation <= kMostDeviation ? std::exp(mean - deviation) : 0.0;
}

bool GroundSpeed::Restore(const State& state) {
  double sum = 0.0;
  for (const double probability : state.probabilities) {
    if (!(probability >= 0.0)) return false;
    sum += probability;
  }
  const bool is_step = state.seconds >= 0.0 && state.onward >= 0.0 &&
                       std::isfinite(state.seconds) && std::isfinite(state.onward);
  if (!is_step || !(std::abs(sum - 1.0) < 1e-6)) return false;
  state_ = state;
  return true;
}

}  // namespace egosieve::vision
