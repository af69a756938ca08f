// The speed of the ground below the camera, in heights of the camera per second, filtered over the
// drive.
//
// The ground's slope between two pictures, g of ground_bound.h, is the speed v times the time
// between them. Two pictures of a blank road hardly show it; within a second lane marks and patches
// do. The state is one of kSpeeds speeds, evenly spaced in the logarithm; at first all are equally
// probable.
//
//   p(v_t | v_(t-1))   log v_t is normal about log v_(t-1), with deviation
//                      q = sqrt(dt) max(kDrift, kAcceleration / v)                         (GS1)
//   p(f | v_t, v_(t-1))  log f is normal about log v_t - log v_(t-1), deviation kOnwardError:
//                      f is how much faster the camera got by the depths of the static scene,
//                      `onward` of camera_step.h times the ratio of the steps' times       (GS2)
//   p(pictures | v)    (1 - w) exp(L(none)) + w exp(L(v)), w = kShown                      (GS3)
//   p(g | v)           (1 - w) u + w N(log(g / dt); log v, kGroundError), u even over the speeds:
//                      g by the places that flow follows, which may also be of traffic     (GS4)
//
// L is the log-likelihood of ground_search.h, and `none` its hypothesis without ground. The
// logarithms of (GS3) and (GS4) are divided by kFrameCorrelation, since consecutive pictures repeat
// each other's errors. Where nothing shows the ground the deviation grows until the speed counts as
// unknown. Otherwise the static scene would seem to move when the camera stops.
#pragma once

#include <array>

namespace egosieve::vision {

inline constexpr int kSpeeds = 60;
inline constexpr double kLeastSpeed = 0.6, kGreatestSpeed = 45.0;  // heights per second

// Speed `k` of kSpeeds.
double SpeedAt(int k);

// L of every speed, then that of no ground; up to a constant.
using SpeedLikelihood = std::array<double, kSpeeds + 1>;

// What a picture and those beside it show.
struct GroundObservation {
  SpeedLikelihood pictures{};
  double speed = 0.0;  // g / dt of (GS4), heights per second; 0: not known
};

class GroundSpeed {
 public:
  using Probabilities = std::array<double, kSpeeds>;

  struct State {
    Probabilities probabilities{};
    // Of the last step: its time, and `onward` of camera_step.h; 0: not known.
    double seconds = 0.0, onward = 0.0;
  };

  GroundSpeed();

  // Advances by one picture. seconds: since the previous picture, positive.
  void Advance(double seconds, const GroundObservation& observation);
  // By how much the next step is longer than the last one; 0: not known.
  void SetOnward(double onward) { state_.onward = onward; }

  // The speed one deviation below the mean of its logarithm; 0 where it is not known.
  double Low() const;

  const State& state() const { return state_; }
  // Returns whether this is a valid state; unchanged if not.
  bool Restore(const State& state);

 private:
  State state_;
};

}  // namespace egosieve::vision
