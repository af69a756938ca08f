// The direction of travel over a drive, sharpened by the ground.
//
// Flow tells the direction in which a camera travels to a degree or two, for it can hardly be told
// from a rotation. Lane marks and patches of the road move along lines through the point that the
// camera moves to, and the nearer that point is to their row the less they move: how well several
// pictures of the ground agree (ground_search.h) depends on the direction d. It maximises
//
//   J(d) = log p(d) + sum over views of log( exp(L_none(d)) / 2 + mean over v of exp(L_v(d)) / 2 )
//                                                                                          (GD1)
//
// by steps across and down that halve, from the prior's mean.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_

#include <Eigen/Core>
#include <vector>

#include "vision/trajectory/ground_search.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

// d, a unit vector. prior: known; views: their direction is not read. The prior's mean where the
// camera does not move forward or back, and where no ground is seen.
Eigen::Vector3d DirectionByGround(const TravelPrior& prior, std::vector<GroundSearchView> views);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_DIRECTION_H_
