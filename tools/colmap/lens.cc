#include "tools/colmap/lens.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {

absl::StatusOr<vision::Lens> LensOf(const SparseCamera& camera) {
  const CameraModel& model = *FindCameraModel(camera.model);
  if (model.lens == LensKind::kOther) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera ", camera.id, ": the distortion of the model ", model.name,
                     " cannot be undone; that of the perspective models and fisheyes with radial "
                     "distortion can"));
  }
  const double* next = camera.parameters.data();
  vision::Lens lens;
  lens.is_fisheye = model.lens == LensKind::kFisheye;
  lens.fx = lens.fy = *next++;
  if (model.focals == 2) lens.fy = *next++;
  lens.cx = *next++;
  lens.cy = *next++;
  std::copy(next, camera.parameters.data() + camera.parameters.size(), lens.distortion.begin());
  if (!(lens.fx > 0.0) || !(lens.fy > 0.0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera ", camera.id, ": its focal length is not positive; reconstruct it again"));
  }
  return lens;
}

}  // namespace egosieve::tools
