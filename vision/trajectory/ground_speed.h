// The speed of the ground below the camera, in heights of the camera per second, filtered over the
// drive.
//
// The ground's slope between two pictures, g of ground_bound.h, is the speed v times the time
// between them. Two consecutive pictures of a blank road hardly show it; within a second lane marks
// and patches do. The state is one of kSpeeds speeds, evenly spaced in the logarithm, or `none`: no
// ground is visible.
//
//   p(v_t | v_(t-1))   log v_t is normal about log v_(t-1), with deviation
//                      sqrt(dt) max(kDrift, kAcceleration / v)                             (GS1)
//   p(none | v)        1 - exp(-dt / kMemorySeconds), and as much from none to all speeds  (GS2)
//   p(v | pictures)    is proportional to p(v) exp(L(v) / kFrameCorrelation)               (GS3)
//
// L is the log-likelihood of ground_search.h. It is divided by kFrameCorrelation, since consecutive
// pairs of pictures repeat each other's errors. The ground is forgotten where the pictures do not
// show it for a while. Otherwise the static scene would seem to move when the camera stops.
#pragma once

#include <array>

namespace egosieve::vision {

inline constexpr int kSpeeds = 60;
inline constexpr double kLeastSpeed = 0.6, kGreatestSpeed = 45.0;  // heights per second

// Speed `k` of kSpeeds.
double SpeedAt(int k);

// L of every speed, then that of no ground; up to a constant.
using SpeedLikelihood = std::array<double, kSpeeds + 1>;

class GroundSpeed {
 public:
  using Probabilities = std::array<double, kSpeeds + 1>;  // the last is that of no ground

  GroundSpeed();

  // Advances by one picture. seconds: since the previous picture, positive.
  void Advance(double seconds, const SpeedLikelihood& likelihood);

  // The speed one deviation below the mean of its logarithm; 0 where it is not known.
  double Low() const;

  const Probabilities& probabilities() const { return probabilities_; }
  // Returns whether these are valid probabilities; unchanged if not.
  bool Restore(const Probabilities& probabilities);

 private:
  Probabilities probabilities_;
};

}  // namespace egosieve::vision
