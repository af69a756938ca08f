#include "vision/trajectory/ground_speed.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/trajectory/camera_step.h"

namespace egosieve::vision {
namespace {

constexpr double kDrift = 0.16;        // of log v, per square root of a second
constexpr double kAcceleration = 2.3;  // heights per second^2: braking at 3 m/s^2
constexpr double kShown = 0.7, kSlopeOfGround = 0.5;
constexpr double kFrameCorrelation = 6.0;
constexpr double kLeastDeviation = 0.3;  // of a change, in steps of the state
// Streets: 6 to 17 on drives with known poses.
constexpr double kSceneDepth = 12.0, kSceneSpread = 0.7;  // heights; of the logarithm
constexpr double kGreatestDepth = 100.0;
constexpr double kStands = 0.05;    // heights per second: what is slower counts as this in (GS5)
constexpr double kBelowLow = 0.16;  // one deviation of a normal distribution

double Step() { return std::asinh(kGreatestSpeed / kSlowSpeed) / (kSpeeds - 1); }

// log p(v_t | v_(t-1), f) up to a constant is -(x_t - x_(t-1) - mean)^2 / (2 deviation^2).
struct Change {
  double mean = 0.0, deviation = 0.0;
};

// (GS1) and (GS2) together. The scene of a camera that hardly moves has no measurable depth.
Change ChangeFrom(double speed, double seconds, double faster) {
  const double slope = 1.0 / std::hypot(speed, kSlowSpeed);  // dx/dv
  const double drift = slope * std::sqrt(seconds) * std::max(kDrift * speed, kAcceleration);
  if (!(faster > 0.0) || speed < kSlowSpeed) return {0.0, drift};
  const double error = slope * speed * kOnwardError;
  const double gain = drift * drift / (drift * drift + error * error);
  return {gain * slope * speed * std::log(faster), std::sqrt(gain) * error};
}

// The logarithm of share exp(log_density) + (1 - share) U, U even over the speeds.
double LogOrAnySpeed(double share, double log_density) {
  return std::log(share * std::exp(log_density) + (1.0 - share) / (Step() * (kSpeeds - 1)));
}

// Of log(speed / expected).
double LogNormal(double speed, double expected, double deviation) {
  const double z = std::log(std::max(speed, 1e-6) / expected) / deviation;
  return -0.5 * z * z - std::log(deviation * std::sqrt(2.0 * std::numbers::pi));
}

// How much of an observation is new after those before it.
struct NewShares {
  double pictures = 1.0, scene = 1.0;  // of (GS3) and (GS4); of (GS5)
};

// The logarithms of (GS3) to (GS5) for each speed.
SpeedLikelihood LogLikelihoods(const GroundObservation& observation, const NewShares& shares) {
  const double top = *std::max_element(observation.pictures.begin(), observation.pictures.end());
  double mean = 0.0;
  for (const double value : observation.pictures) mean += std::exp(value - top) / kSpeeds;
  SpeedLikelihood logs;
  for (int k = 0; k < kSpeeds; ++k) {
    const double speed = SpeedAt(k);
    double frame =
        std::log(kShown * std::exp(observation.pictures[k] - top) + (1.0 - kShown) * mean);
    if (observation.speed > 0.0) {
      frame += LogOrAnySpeed(kSlopeOfGround, LogNormal(speed, observation.speed, kGroundError));
    }
    logs[k] = shares.pictures * frame;
    if (!(observation.scene_parallax > 0.0)) continue;
    const double depth = std::max(speed, kStands) / observation.scene_parallax;
    const double beyond = std::max(0.0, std::log(depth / kGreatestDepth)) / kSceneSpread;
    logs[k] += shares.scene * LogNormal(depth, kSceneDepth, kSceneSpread) - 0.5 * beyond * beyond;
  }
  return logs;
}

}  // namespace

double SpeedAt(int k) { return kSlowSpeed * std::sinh(k * Step()); }

GroundSpeed::GroundSpeed() { state_.probabilities.fill(1.0 / kSpeeds); }

void GroundSpeed::Advance(double seconds, const GroundObservation& observation) {
  const double faster = state_.onward * state_.seconds / seconds;
  const bool is_first = state_.seconds == 0.0;
  const NewShares shares =
      is_first ? NewShares() : NewShares{1.0 / kFrameCorrelation, std::min(seconds, 1.0)};
  state_.onward = 0.0;
  state_.seconds = seconds;
  Probabilities next{};
  for (int from = 0; from < kSpeeds; ++from) {
    const Change change = ChangeFrom(SpeedAt(from), seconds, faster);
    const double expected = std::clamp(from + change.mean / Step(), 0.0, kSpeeds - 1.0);
    const double deviation = std::max(change.deviation / Step(), kLeastDeviation);
    Probabilities kernel;
    double sum = 0.0;
    for (int to = 0; to < kSpeeds; ++to) {
      const double z = (to - expected) / deviation;
      sum += kernel[to] = std::exp(-0.5 * z * z);
    }
    for (int to = 0; to < kSpeeds; ++to) next[to] += state_.probabilities[from] * kernel[to] / sum;
  }
  const SpeedLikelihood logs = LogLikelihoods(observation, shares);
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (int k = 0; k < kSpeeds; ++k) sum += next[k] *= std::exp(logs[k] - top);
  if (!(sum > 0.0) || !std::isfinite(sum)) return;
  for (double& probability : next) probability /= sum;
  state_.probabilities = next;
}

double GroundSpeed::Low() const {
  double below = 0.0;
  int k = 0;
  while (k + 1 < kSpeeds && below + state_.probabilities[k] < kBelowLow) {
    below += state_.probabilities[k++];
  }
  return SpeedAt(k);
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
