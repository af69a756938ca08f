// The direction in which the camera travels, in its own frame, over a drive.
//
// A camera that is fixed to a vehicle travels in one direction, its own, but for sideslip and
// bumps; one that is carried by hand does not. Directions x of several pairs of pictures are taken
// for a mixture of a von Mises-Fisher and a uniform density on the sphere; relative to the uniform,
//
//   q(x) = w 2 k / (1 - exp(-2 k)) exp(k (mu.x - 1)) + 1 - w                               (TP1)
//
// Mean mu, concentration k and share w are found by expectation maximisation. For a camera that is
// carried w is small and log q about zero everywhere. Reference: Banerjee et al. (2005), clustering
// on the unit hypersphere using von Mises-Fisher distributions.
#ifndef EGOSIEVE_VISION_TRAJECTORY_TRAVEL_PRIOR_H_
#define EGOSIEVE_VISION_TRAJECTORY_TRAVEL_PRIOR_H_

#include <Eigen/Core>
#include <vector>

namespace egosieve::vision {

struct TravelPrior {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // mu, a unit vector
  double concentration = 1.0;                            // k, positive
  double share = 0.0;                                    // w, in [0, 1); 0: says nothing

  bool IsKnown() const { return share > 0.0; }
  // Whether most pairs travel in it, forward or back.
  bool IsOfVehicle() const;
  // log q(x) of a unit vector.
  double LogDensity(const Eigen::Vector3d& x) const;
  // How probably a unit vector belongs to the first part of the mixture.
  double Membership(const Eigen::Vector3d& x) const;
};

// directions: unit vectors, one a pair. Says nothing for fewer than six.
TravelPrior FitTravelPrior(const std::vector<Eigen::Vector3d>& directions);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_TRAVEL_PRIOR_H_
