// Albedo and emitted light where a ray meets the road or a primitive. They are drawn from the
// appearance and the point in the primitive's own frame, so that texture moves with its object.
//
//   surface.cc   vehicles, trees, signs, roofs
//   facade.cc    the walls of houses. They are of render or brick, stained, with windows, shop
//                fronts with lettered signs on the ground floor, doors, posters and graffiti.
//                Windows have frames, curtains, blinds and reflections of their own. Everything is
//                drawn from hashes of the house, the wall, the floor and the bay, so that all
//                windows differ
//   ground.cc    asphalt with repairs, cracks, stains, manholes and litter. Where the street grid
//                has them there are lane markings, parking lines, zebra crossings and stop lines,
//                all worn
//
// `footprint`: side of a pixel on the surface, metres. `texture`: contrast; 0: none.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "vision/synthetic/noise.h"
#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

struct SurfaceColor {
  Color albedo = Color::Zero();
  Color emission = Color::Zero();

  SurfaceColor() = default;
  SurfaceColor(const Color& albedo) : albedo(albedo) {}  // NOLINT: most surfaces emit nothing
};

SurfaceColor SurfaceAt(const Primitive& primitive, const Hit& hit, float footprint, float texture);

struct Wall {
  uint32_t house = 0;  // seed
  uint32_t wall = 0;   // seed of this wall
  Color color = Color::Zero();
  float width = 0.0f;  // metres
  float height = 0.0f;
  float texture = 1.0f;  // of stains and bricks
  bool lights_on = false;
};

// At (u, v): metres from the wall's left end and from the ground.
SurfaceColor FacadeColor(const Wall& wall, float u, float v, float footprint);

// Letters: 1 ink, 0 paper. Unit coordinates: one letter is 1 wide and 1 high.
float Lettering(float u, float v, uint32_t seed, float footprint);

struct GroundStyle {
  uint32_t seed = 0;
  float texture = 1.0f;
  bool markings = true;
};

Color GroundAlbedo(const GroundStyle& style, const Eigen::Vector2d& point, float footprint);

// Slabs of concrete.
Color PavementAlbedo(uint32_t seed, float texture, const Eigen::Vector2d& point, float footprint);

// Spots of grit, litter, leaves and stains, at most one per square cell: 0 where there is none,
// otherwise signed contrast.
float Speckles(float x, float y, uint32_t seed, float cell, float density, float footprint);

// Speckles of seven sizes, in cells of `coarsest` metres, half of it, and so on: down to the
// resolution of a pixel.
float Litter(float x, float y, uint32_t seed, float coarsest, float density, float footprint);

inline Color Blend(const Color& a, const Color& b, float t) { return a + (b - a) * t; }

// 1 on the line |x| <= half_width, 0 beside it, softened as SoftStep.
inline float SoftLine(float half_width, float x, float footprint) {
  return 1.0f - SoftStep(half_width, std::abs(x), footprint);
}

// SoftBox in both directions.
inline float SoftRectangle(float left, float right, float u, float low, float high, float v,
                           float footprint) {
  return SoftBox(left, right, u, footprint) * SoftBox(low, high, v, footprint);
}

}  // namespace egosieve::vision
