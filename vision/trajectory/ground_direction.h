// Refines the direction of travel of a drive by the pictures of the ground.
//
// Flow hardly determines the direction of travel, since a change of direction looks almost like a
// rotation. Lane marks and patches of the road move along lines through the point that the camera
// moves towards, and they move less the nearer that point is to their image row. So the agreement
// of several pictures of the ground (ground_search.h) depends on the direction d. The refined d
// maximises
//
//   J(d) = log p(d) + sum over views of log( exp(L_none(d)) / 2 + mean over v of exp(L_v(d)) / 2 )
//                                                                                          (GD1)
//
// by steps across and down from the prior's mean. The steps are halved where none improves J.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_

#include <Eigen/Core>
#include <vector>

#include "vision/trajectory/ground_search.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

// Returns d, a unit vector. `prior` must be known. The directions of the views are not read.
// Returns the prior's mean where the camera does not move forward or back, and where no ground is
// seen.
Eigen::Vector3d DirectionByGround(const TravelPrior& prior, std::vector<GroundSearchView> views);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_
