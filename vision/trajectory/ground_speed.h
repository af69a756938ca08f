// The speed of the ground below the camera, in heights of the camera per second, filtered over the
// drive.
//
// The ground's slope between two pictures, g of ground_bound.h, is the speed v times the time
// between them. Two pictures of a blank road hardly show it; within a second lane marks and patches
// do. The state is one of kSpeeds speeds from 0 on, evenly spaced in x = asinh(v / kSlowSpeed):
// as their logarithm, but for a camera that stands or nearly so. At first all x are equally
// probable.
//
//   p(v_t | v_(t-1))   x_t is normal about x_(t-1), with the deviation by drift and acceleration
//                      sqrt(dt) max(kDrift v, kAcceleration) dx/dv                         (GS1)
//   p(f | v_t, v_(t-1))  log f is normal about log v_t - log v_(t-1), deviation kOnwardError:
//                      f is how much faster the camera got by the depths of the static scene,
//                      `onward` of camera_step.h times the ratio of the steps' times       (GS2)
//   p(pictures | v)    w exp(L(v)) + (1 - w) mean over u of exp(L(u)), w = kShown: what repeats
//                      itself, as lane marks do, shows any other speed                     (GS3)
//   p(g | v)           (1 - u) U + u N(log(g / dt); log v, kGroundError), U even over the speeds:
//                      g by the places that flow follows, which may also be of traffic     (GS4)
//   p(m | v)           log(v dt / m) is normal about log kSceneDepth, deviation kSceneSpread: m
//                      is the mean parallax of the static scene, and v dt / m its depth, heights;
//                      beyond kGreatestDepth its density falls as that of a normal one    (GS5)
//
// L is the log-likelihood of ground_search.h. The first picture counts in full. Later ones repeat its
// errors: the logarithms of (GS3) and (GS4) are divided by kFrameCorrelation. The scene's depth is
// the same for seconds, so (GS5) counts once a second, but for its fall: no picture shows a scene
// that is beyond all scenes.
#pragma once

#include <array>

namespace egosieve::vision {

inline constexpr int kSpeeds = 70;
inline constexpr double kSlowSpeed = 0.6, kGreatestSpeed = 45.0;  // heights per second

// Speed `k` of kSpeeds; the first is 0.
double SpeedAt(int k);

// L of every speed, up to a constant.
using SpeedLikelihood = std::array<double, kSpeeds>;

// What a picture and those beside it show.
struct GroundObservation {
  SpeedLikelihood pictures{};
  double speed = 0.0;           // g / dt of (GS4), heights per second; 0: not known
  double scene_parallax = 0.0;  // m / dt of (GS5), per second; 0: not known
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

  // The speed above which the ground's speed is with a probability of 1 - kBelowLow.
  double Low() const;

  const State& state() const { return state_; }
  // Returns whether this is a valid state; unchanged if not.
  bool Restore(const State& state);

 private:
  State state_;
};

}  // namespace egosieve::vision
