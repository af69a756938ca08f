// The lens of COLMAP's camera models that OpenCV has, too.
//
// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV and FULL_OPENCV are perspective;
// SIMPLE_FISHEYE, FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE and OPENCV_FISHEYE are fisheyes.
#pragma once

#include "absl/status/statusor.h"
#include "tools/colmap/sparse_model.h"
#include "vision/geometry/lens.h"

namespace egosieve::tools {

// InvalidArgument for other models, and for focal lengths that are not positive.
absl::StatusOr<vision::Lens> LensOf(const SparseCamera& camera);

}  // namespace egosieve::tools
