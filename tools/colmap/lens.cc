#include "tools/colmap/lens.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {

std::array<double, 2> Lens::Project(double u, double v) const {
  const std::array<double, 8>& d = distortion;
  const double r2 = u * u + v * v;
  if (is_fisheye) {
    const double r = std::sqrt(r2);
    const double t = std::atan(r), t2 = t * t;
    const double along = t * (1.0 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
    const double scale = r > 0.0 ? along / r : 1.0;
    return {fx * scale * u + cx, fy * scale * v + cy};
  }
  const double s =
      (1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1.0 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
  return {fx * (s * u + 2.0 * d[2] * u * v + d[3] * (r2 + 2.0 * u * u)) + cx,
          fy * (s * v + 2.0 * d[3] * u * v + d[2] * (r2 + 2.0 * v * v)) + cy};
}

bool Lens::is_pinhole() const {
  return !is_fisheye && std::all_of(distortion.begin(), distortion.end(),
                                    [](double coefficient) { return coefficient == 0.0; });
}

absl::StatusOr<Lens> LensOf(const SparseCamera& camera) {
  const CameraModel& model = *FindCameraModel(camera.model);
  if (model.lens == LensKind::kOther) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera ", camera.id, ": masks of the model ", model.name,
                     " cannot be undistorted; the perspective models and fisheyes with radial "
                     "distortion can"));
  }
  const double* next = camera.parameters.data();
  Lens lens;
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
