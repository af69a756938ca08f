// The synthetic town: streets on a rectangular grid, blocks between them.
//
// World axes: x along the main streets, y to the left of it, z up, metres; the road's surface is z
// = 0. Streets run along x at y = j pitch_y and along y at x = i pitch_x, for all integers i, j.
// From the centre line of a street outwards lie a driving lane, a parking strip, the kerb, the
// pavement and the houses, on both sides. Traffic keeps to the right.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "vision/synthetic/scene.h"

namespace egosieve::vision {

inline constexpr double kPitchX = 66.0;
inline constexpr double kPitchY = 74.0;
inline constexpr double kLaneWidth = 3.3;  // one lane per side
inline constexpr double kKerb = 5.5;       // from the centre line; beyond: pavement
inline constexpr double kHouseLine = 9.2;  // from the centre line
inline constexpr double kKerbHeight = 0.12;
inline constexpr double kLaneCentre = kLaneWidth / 2;
inline constexpr double kParkingCentre = (kLaneWidth + kKerb) / 2;

inline double NearestMultiple(double x, double pitch) { return pitch * std::round(x / pitch); }

// Fills the grid around the points that the camera passes: houses, pavements, trees, lamps, signs
// and parked cars.
void AppendTown(const std::vector<Eigen::Vector2d>& camera_points, Scene* scene);

}  // namespace egosieve::vision
