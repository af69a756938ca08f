// The walls of houses. They are of render or brick, stained, with windows, shop fronts with
// lettered signs on the ground floor, doors, posters and graffiti. Windows have frames, curtains,
// blinds and reflections of their own. Everything is drawn from hashes of the house, the wall, the
// floor and the bay, so that all windows differ.
#pragma once

#include <cstdint>

#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

struct SurfaceColor {
  Color albedo = Color::Zero();
  Color emission = Color::Zero();
};

struct Wall {
  uint32_t house = 0;  // seed
  uint32_t wall = 0;   // seed of this wall
  Color color = Color::Zero();
  float width = 0.0f;    // metres
  float height = 0.0f;   // metres
  float texture = 1.0f;  // contrast of stains and bricks
  bool lights_on = false;
};

// At (u, v): metres from the wall's left end and from the ground.
SurfaceColor FacadeColor(const Wall& wall, float u, float v, float footprint);

// Letters: 1 ink, 0 paper. Unit coordinates: one letter is 1 wide and 1 high.
float Lettering(float u, float v, uint32_t seed, float footprint);

}  // namespace egosieve::vision
