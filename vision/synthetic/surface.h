// Albedo and emitted light where a ray meets a primitive. They are drawn from the primitive's
// appearance and the point in its own frame, so that texture moves with its object.
#pragma once

#include "vision/synthetic/facade.h"
#include "vision/synthetic/ground.h"
#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

// `footprint`: side of a pixel on the surface, metres. `texture`: contrast of scenery, 0 to 1.
SurfaceColor SurfaceAt(const Primitive& primitive, const Hit& hit, float footprint, float texture);

}  // namespace egosieve::vision
