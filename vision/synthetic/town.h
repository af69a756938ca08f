// Fills the street grid with houses, pavements, trees, lamps, signs and parked cars.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/synthetic/scene.h"

namespace egosieve::vision {

struct TownOptions {
  uint32_t seed = 0;
  double reach_metres = 150.0;  // around the points that the camera passes
  double min_height_metres = 8.0;
  double max_height_metres = 24.0;
  double parked = 0.55;  // share of parking bays with a car
  double trees = 0.75;   // share of tree places with a tree
  bool lights_on = false;
};

// Adds the town around `camera_points` to `scene`: scenery, lamps and parked cars.
void AppendTown(const TownOptions& options, const std::vector<Eigen::Vector2d>& camera_points,
                Scene* scene);

}  // namespace egosieve::vision
