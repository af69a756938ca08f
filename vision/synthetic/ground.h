// The road's surface: asphalt with repairs, cracks, stains, manholes and litter. Where the street
// grid has them there are lane markings, parking lines, zebra crossings and stop lines, all worn.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

struct GroundStyle {
  uint32_t seed = 0;
  float texture = 1.0f;  // contrast of the asphalt's texture; 0: none
  bool markings = true;
};

// Mean albedo at (x, y), metres, over a pixel's footprint (metres).
Color GroundAlbedo(const GroundStyle& style, const Eigen::Vector2d& point, float footprint);

// Slabs of concrete; `texture` as above.
Color PavementAlbedo(uint32_t seed, float texture, const Eigen::Vector2d& point, float footprint);

// Spots of grit, litter, leaves and stains, at most one per square cell: 0 where there is none,
// otherwise signed contrast.
float Speckles(float x, float y, uint32_t seed, float cell, float density, float footprint);

// Speckles of seven sizes, in cells of `coarsest` metres, half of it, and so on: down to the
// resolution of a pixel.
float Litter(float x, float y, uint32_t seed, float coarsest, float density, float footprint);

}  // namespace egosieve::vision
