// How fast the ground passes below the camera, in heights of the camera per second, filtered over
// the drive.
//
// The ground's slope between two pictures, g of ground_bound.h, is the speed v times the time
// between them. Two consecutive pictures of a blank road hardly show it; over a second lane marks
// and patches do. The speed is one of kSpeeds values, evenly spread in the logarithm, or there is
// no ground to be seen:
//
//   p(v_t | v_(t-1))   log v_t is normal about log v_(t-1), with deviation
//                      sqrt(dt) max(kDrift, kAcceleration / v)                             (GS1)
//   p(none | v)        1 - exp(-dt / kMemorySeconds), and as much from none to all speeds  (GS2)
//   p(v | pictures)    is proportional to p(v) exp(L(v) / kFrameCorrelation)               (GS3)
//
// with L the log likelihood of ground_search.h: what two pictures get wrong, the next two do, too.
// Where the pictures say nothing for a while, the ground is forgotten: a camera that stops would
// otherwise take the world for moving.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_SPEED_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_SPEED_H_

#include <array>

namespace egosieve::vision {

inline constexpr int kSpeeds = 60;
inline constexpr double kLeastSpeed = 0.6, kGreatestSpeed = 45.0;  // heights per second

// Speed `k` of kSpeeds.
double SpeedAt(int k);

// L of every speed, and last that of no ground; up to a constant.
using SpeedLikelihood = std::array<double, kSpeeds + 1>;

class GroundSpeed {
 public:
  using Probabilities = std::array<double, kSpeeds + 1>;  // the last: no ground

  GroundSpeed();

  // A picture later. seconds: since the picture before, positive.
  void Advance(double seconds, const SpeedLikelihood& likelihood);

  // One deviation below the mean of the logarithm; 0 where the speed is not known.
  double Low() const;

  const Probabilities& probabilities() const { return probabilities_; }
  // Whether they are probabilities; unchanged if not.
  bool Restore(const Probabilities& probabilities);

 private:
  Probabilities probabilities_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_SPEED_H_
