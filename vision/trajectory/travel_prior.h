// The camera's direction of travel, in its own frame, over a drive.
//
// A camera that is fixed to a vehicle travels in one direction in its own frame, except for
// sideslip and bumps. A hand-held camera does not. The directions x of several pairs of pictures
// are modelled as a mixture of a von Mises-Fisher and a uniform density on the sphere. Relative to
// the uniform density,
//
//   q(x) = w 2 k / (1 - exp(-2 k)) exp(k (mu.x - 1)) + 1 - w                               (TP1)
//
// Mean mu, concentration k and share w are estimated by expectation maximisation. For a hand-held
// camera w is small and log q is about zero everywhere. Reference: Banerjee et al. (2005),
// clustering on the unit hypersphere using von Mises-Fisher distributions.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace egosieve::vision {

struct TravelPrior {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // mu, a unit vector
  double concentration = 1.0;                            // k, positive
  double share = 0.0;                                    // w, in [0, 1); 0: not known

  // Probability that a vehicle does not travel in its own direction, as when it skids.
  static constexpr double kVehicleTravelsElsewhere = 1e-6;
  // With fewer it is not known.
  static constexpr int kFewestDirections = 6;

  bool IsKnown() const { return share > 0.0; }
  // Whether most pairs travel in nearly the same `direction`, and this is forward or back. Not so
  // where a person carries the camera.
  bool IsOfVehicle() const;
  // log q(x); x: a unit vector.
  double LogDensity(const Eigen::Vector3d& x) const;
  // The probability that the unit vector x belongs to the von Mises-Fisher part of the mixture.
  double Membership(const Eigen::Vector3d& x) const;
};

// directions: unit vectors, one per pair.
TravelPrior FitTravelPrior(const std::vector<Eigen::Vector3d>& directions);

}  // namespace egosieve::vision
